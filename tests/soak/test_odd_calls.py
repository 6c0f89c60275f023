"""Arguments that once raised a raw error or a warning; warnings are errors here."""

import os

import pytest

import ancfsparse as ancf
from tests.soak.odd import all_calls, check_sentence
from tests.soak.values import VALUES


@pytest.fixture(scope="module")
def every(tmp_path_factory):
    before = os.getcwd()
    os.chdir(tmp_path_factory.mktemp("odd"))
    yield {call.name: call for call in all_calls()}
    os.chdir(before)


@pytest.mark.parametrize(
    ("name", "parameter", "value"),
    [
        ("Scene.record_of", "handle", "object"),
        ("Scene.record_of", "handle", "itself"),
        ("Trajectory.animate", "trace", "a node elsewhere"),
        ("Trajectory.animate", "seconds", "1e30"),
        ("Trajectory.animate", "fps", "uint64"),
        ("Trajectory.animate", "dpi", "10**20"),
        ("Modes.state", "mode", "timedelta64"),
        ("Modes.plot", "mode", "-10**5000"),
        ("Modes.plot", "amplitude", "1e308"),
        ("ComplexModes.moving", "amplitude", "1e308"),
        ("LoadPath.state", "point", "-10**5000"),
        ("LoadPath.plot", "axis", "zeros(2)"),
        ("LoadPath.plot", "axis", "-0.0"),
        ("Plan.run", "verify", "zeros(2)"),
        ("grid", "length", "array()"),
        ("grid", "length", "rude"),
        ("sweep", "points", "array()"),
        ("sweep with options", "integrator", "rude"),
        ("modal_response", "damping", "1e308"),
        ("joint_spring", "stiffness", "1e308"),
        ("joint_friction by a coefficient", "radius", "1e308"),
    ],
)
def test_what_once_raised_is_refused_in_a_sentence(every, name, parameter, value):
    call = every[name]
    with pytest.raises(ancf.AncfError) as caught:
        call.function(**(call.given | {parameter: VALUES[value]()}))
    assert check_sentence(name, str(caught.value)) == []


@pytest.mark.parametrize("error", [5e-324, 1e-30])
def test_a_plan_for_an_error_beyond_reach_tells_what_is_reached(every, error):
    call = every["plan for a slope_angle"]
    assert not call.function(**(call.given | {"error": error})).is_met


def test_a_negative_number_counts_from_the_last(every):
    state = every["Modes.state"].function
    assert (state(-1, 1e-3).q == state(1, 1e-3).q).all()
