"""The model in an FMU: a simulation of its scene with inputs and outputs by name."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.scene import Input, Scene
from ancfsparse.scene.storage.json_file import built_from_records, decoded
from ancfsparse.solve import Simulation

# Files in the FMU.
SCENE = "scene.json"
SETTINGS = "settings.json"
OPTIONS = "options.pickle"
AXES = "xyz"
TIME = "time"  # name of the independent variable


class OutputQuantity(NamedTuple):
    """A result that an FMU may have as an output.

    Attributes
    ----------
    unit : str
        Its SI unit.
    evaluate : callable
        Function of a simulation and a handle that returns it.
    """

    unit: str
    evaluate: Callable[[Simulation, Any], ArrayLike]


QUANTITIES = {
    "position": OutputQuantity("m", Simulation.position),
    "velocity": OutputQuantity("m/s", Simulation.velocity),
    "acceleration": OutputQuantity("m/s2", Simulation.acceleration),
    "reaction": OutputQuantity("N", Simulation.reaction),
    "joint_force": OutputQuantity(
        "N", lambda simulation, joint: simulation.joint_force(joint).force
    ),
    "joint_moment": OutputQuantity(
        "N.m", lambda simulation, joint: simulation.joint_force(joint).moment
    ),
    "tension": OutputQuantity("N", Simulation.tension),
}
UNITS: dict[str, dict[str, int]] = {
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
}
"""Exponents of base units."""


def list_components(name: str, size: int) -> list[str]:
    """Return the names of the variables of a number or a vector."""
    return [name] if size == 1 else [f"{name}.{axis}" for axis in AXES[:size]]


class FmuModel:
    """A simulation of the scene in the resources of an FMU.

    Parameters
    ----------
    folder : Path
        The resources.

    Attributes
    ----------
    name : str
        Name of the model.
    dt : float
        Time step [s].
    inputs : dict of str to float
        Values of input variables [unit of their uses].
    outputs : dict of str to str
        Units of output variables.
    """

    def __init__(self, folder: Path) -> None:
        self._file = folder / SCENE
        settings: dict[str, Any] = json.loads((folder / SETTINGS).read_text(encoding="utf-8"))
        self._options: dict[str, Any] = pickle.loads((folder / OPTIONS).read_bytes())
        self.name, self.dt = str(settings["name"]), float(settings["dt"])
        self._inputs = [decoded(each, {}) for each in settings["inputs"]]
        self._rates: Mapping[str, str] = settings["rates"]
        self._results: Mapping[str, Mapping[str, Any]] = settings["outputs"]
        self.inputs: dict[str, float] = {}
        for each in self._inputs:
            names = list_components(each.name, each.size)
            self.inputs |= zip(names, np.ravel(each.default).tolist(), strict=True)
            if each.name in self._rates:
                rates = list_components(self._rates[each.name], each.size)
                self.inputs |= dict.fromkeys(rates, 0.0)
        self._components = {
            component: (name, k)
            for name, each in self._results.items()
            for k, component in enumerate(list_components(name, each["size"]))
        }
        self.outputs = {
            component: QUANTITIES[self._results[name]["what"]].unit
            for component, (name, _) in self._components.items()
        }
        self._simulation: Simulation | None = None
        self._start: dict[str, float] = {}
        self._handles: dict[str, Any] = {}
        self._values: dict[str, Vector] = {}

    @property
    def time(self) -> float:
        """Present time of the simulation [s]."""
        return 0.0 if self._simulation is None else self._simulation.t

    def begin(self) -> None:
        """Set up the simulation at its start, with the present values of the inputs.

        Raises
        ------
        InputError
            If the scene cannot start with them.
        """
        if self._simulation is not None and self._start == self.inputs:
            return
        data = json.loads(self._file.read_text(encoding="utf-8"))
        _set_defaults(data, {each.name: self._read(each.name, each.size) for each in self._inputs})
        scene = built_from_records(Scene, data, self._file, {})
        self._handles = {name: _find(scene, each["of"]) for name, each in self._results.items()}
        self._simulation = Simulation(scene, self.dt, **self._options)
        self._start, self._values = dict(self.inputs), {}

    def step(self, duration: float) -> None:
        """Set all inputs, by ramps over a duration [s], and take the steps in it.

        Raises
        ------
        InputError
            If it is not a number of time steps.
        StepError
            If a step fails.
        """
        assert self._simulation is not None
        over = max(1, round(duration / self.dt)) * self.dt  # without the rounding of the importer
        for each in self._inputs:
            rate = self._rates.get(each.name)
            self._simulation.set(
                each,
                self._read(each.name, each.size),
                rate=None if rate is None else self._read(rate, each.size),
                over=over,
            )
        self._values = {}
        self._simulation.run_until(self._simulation.t + duration)

    def output(self, component: str) -> float:
        """Return an output variable at the present time; NaN before the start."""
        if self._simulation is None:
            return float("nan")
        name, k = self._components[component]
        if name not in self._values:
            quantity = QUANTITIES[self._results[name]["what"]]
            value = quantity.evaluate(self._simulation, self._handles[name])
            self._values[name] = np.ravel(value)
        return float(self._values[name][k])

    def _read(self, name: str, size: int) -> Any:
        values = [self.inputs[each] for each in list_components(name, size)]
        return values if size > 1 else values[0]


def _find(scene: Scene, reference: Any) -> Any:
    """Return a handle from its data in the settings."""
    if "list" in reference:
        return getattr(scene, reference["list"])[reference["number"]]
    return decoded(reference, {}).of(scene)


def _set_defaults(data: Any, defaults: Mapping[str, Any]) -> None:
    """Set the defaults of inputs in the data of a scene."""
    if isinstance(data, dict):
        if data.get("kind") == Input.__name__ and data["name"] in defaults:
            data["default"] = defaults[data["name"]]
        data = list(data.values())
    if isinstance(data, list):
        for each in data:
            _set_defaults(each, defaults)
