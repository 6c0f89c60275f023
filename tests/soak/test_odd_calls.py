"""Spoiled calls: all public callables, those that once broke, and a bug that is found."""

import numpy as np
import pytest

import ancfsparse as ancf
from tests.soak.trials import spoiled_calls
from tests.soak.trials.odd_values import NUMBERS, OBJECTS, labelled
from tests.soak.trials.spoiled_calls import call, find_calls, parameters_of

NEEDED = {"Trajectory.render": "pyvista", "Trajectory.to_gltf": "pygltflib"}
"""Modules of extras that calls need."""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("name", find_calls())
def test_every_call_works_with_its_valid_arguments(name):
    if name in NEEDED:
        pytest.importorskip(NEEDED[name])
    assert None in [call(name, dim, {}) for dim in (2, 3)]


def test_calls_parameters_and_values_are_many():
    assert len(find_calls()) > 150
    assert sum(len(parameters_of(name)) for name in find_calls()) > 500
    assert len(NUMBERS) + len(OBJECTS) > 65


ARRAY = ("zeros(2)", lambda: [0.0, 0.0])
ONCE = [
    ("Scene.record_of", "handle", "object"),
    ("Scene.record_of", "handle", "itself"),
    ("Trajectory.animate", "trace", "a node elsewhere"),
    ("Trajectory.animate", "seconds", 1e30),
    ("Trajectory.animate", "fps", 2**64 - 1),
    ("Trajectory.animate", "dpi", 10**20),
    ("Modes.state", "mode", np.timedelta64(1, "s")),
    ("Modes.plot", "mode", "-10**5000"),
    ("Modes.plot", "amplitude", 1e308),
    ("ComplexModes.moving", "amplitude", 1e308),
    ("LoadPath.state", "point", "-10**5000"),
    ("LoadPath.plot", "axis", ARRAY),
    ("LoadPath.plot", "axis", -0.0),
    ("Plan.run", "verify", ARRAY),
    ("grid", "length", 0.1),
    ("grid", "length", "rude"),
    ("sweep", "points", 0.1),
    ("sweep", "integrator", "rude"),
    ("modal_response", "damping", 1e308),
    ("Scene.joint_spring", "stiffness", 1e308),
    ("Scene.joint_friction, by a coefficient", "radius", 1e308),
    ("Scene.drive", "position", "function to 1e300"),
    ("Ramp", "value", (1e300, 1e300)),
    ("Scene.spring", "length", 1e308),
    ("Scene.add_beam", "length", 1e-300),
]


@pytest.mark.parametrize(("name", "parameter", "value"), ONCE)
def test_what_once_raised_is_refused_in_a_sentence(name, parameter, value):
    odd = (
        (value, OBJECTS[value]) if isinstance(value, str) and value in OBJECTS else labelled(value)
    )
    odd = value if value is ARRAY else odd
    assert call(name, 3 if name == "Scene.joint_spring" else 2, {parameter: odd})


def test_a_raw_error_is_found_and_the_call_is_named(monkeypatch):
    assert spoiled_calls.run(3, 0).finds == []

    def broken(number=None):
        return 1 / (number is None)

    monkeypatch.setattr(ancf, "frequency", broken)
    with pytest.raises(AssertionError, match=r"frequency\(number=7\) raised ZeroDivisionError"):
        call("frequency", 2, {"number": labelled(7)})
