"""Scenes as FMUs for co-simulation by FMI 3."""

from __future__ import annotations

import json
import pickle
import re
import shutil
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ancfsparse.checks import check_choice
from ancfsparse.embedding.fmu_model import (
    OPTIONS,
    QUANTITIES,
    SCENE,
    SETTINGS,
    TIME,
)
from ancfsparse.errors import InputError
from ancfsparse.file_names import check_target
from ancfsparse.messages import format_value
from ancfsparse.scene import Input, Point, Scene, check_scene
from ancfsparse.scene.storage.json_file import encoded
from ancfsparse.solve import Simulation

try:
    from pythonfmu3 import FmuBuilder
except ImportError:  # the extra `fmu` is not installed
    FmuBuilder = None

SLAVE = Path(__file__).with_name("fmu_slave.py")
NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
RATE = "_rate"  # end of the name of the rate of an input


def write(
    path: str | Path,
    scene: Scene,
    *,
    inputs: Sequence[Input] = (),
    outputs: Mapping[str, tuple[str, Any]],
    dt: float,
    rates: Sequence[Input] = (),
    **options: Any,
) -> Path:
    """Write a scene as an FMU for co-simulation by FMI 3.

    It contains the scene as a file.  In each communication step, which must be a number of time
    steps, inputs change smoothly from their present values to those that were set, and reach them
    at its end; those that are set during initialization are the values at the start, by default the
    defaults of the inputs.  Vectors are variables of their components, such as ``push.x``.

    Parameters
    ----------
    path : str or Path
        The file, such as ``"pendulum.fmu"``; an older one is replaced.
    scene : Scene
        The scene, without functions of Python.
    inputs : sequence of Input, optional
        Inputs of the scene that are inputs of the FMU, under their names [unit of their uses].
        Others keep their defaults.
    outputs : dict of str to (str, handle)
        Outputs by name: a result and its point, joint or rope, as in ``{"tip": ("position",
        rod.end)}``.  Results are ``"position"`` [m], ``"velocity"`` [m/s], ``"acceleration"``
        [m/s2] and ``"reaction"`` [N] of points, ``"joint_force"`` [N] and ``"joint_moment"`` [N m]
        of joints, and ``"tension"`` [N] of ropes and winches.
    dt : float
        Time step [s].
    rates : sequence of Input, optional
        Inputs among them, such as drives and lengths, whose rate at the end of a communication
        step is an input as well, with ``_rate`` appended to the name [unit/s]; otherwise it is
        zero.
    **options
        Further arguments of `Simulation`.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If an argument is invalid, the scene has functions, or pythonfmu3 is not installed.

    Notes
    -----
    The machine that runs the FMU needs ancfsparse in its Python, and 64-bit x86 Linux or Windows;
    docs/simulation.md describes it.
    """
    if FmuBuilder is None:
        raise InputError(
            "an FMU needs pythonfmu3, which is not installed: pip install 'ancfsparse[fmu]', or "
            "step a Simulation"
        )
    check_scene(scene)
    target = check_target("an FMU", path, [".fmu"])
    model = re.sub(r"\W", "_", target.stem, flags=re.ASCII)
    model = model if NAME.fullmatch(model) else f"_{model}"
    simulation = Simulation(scene, dt, **options)
    for what, group in (("inputs", inputs), ("rates", rates)):
        if not isinstance(group, Sequence) or not all(isinstance(each, Input) for each in group):
            raise InputError(f"{what} must be a list of Input, got {format_value(group)}")
    for each in (*inputs, *rates):
        simulation.value(each)  # refuses inputs that the scene does not use
    names = {each.name for each in inputs}
    for each in rates:
        if each.name not in names:
            raise InputError(f"{each.name} has a rate and is not among the inputs: add it there")
    if not isinstance(outputs, Mapping) or not outputs:
        raise InputError(
            "outputs must name results, such as {'tip': ('position', rod.end)}, got "
            f"{format_value(outputs)}"
        )
    results = {name: _describe(scene, simulation, name, result) for name, result in outputs.items()}
    _check_names(
        (each.name for each in inputs), (each.name + RATE for each in rates), results.keys()
    )
    settings = {
        "name": model,
        "dt": simulation.dt,
        "inputs": [encoded(each, f"input {each.name}", {}) for each in inputs],
        "rates": {each.name: each.name + RATE for each in rates},
        "outputs": results,
    }
    with TemporaryDirectory() as name:
        folder = Path(name)
        scene.save(folder / SCENE)
        try:
            Scene.load(folder / SCENE)
        except InputError as error:
            reason = (
                str(error).removeprefix(f"{folder / SCENE}, ").partition(": give it to load")[0]
            )
            raise InputError(
                f"an FMU cannot contain this scene: {reason}: take a signal such as Sine or Table, "
                "or an Input"
            ) from error
        (folder / SETTINGS).write_text(json.dumps(settings, indent=1), encoding="utf-8")
        (folder / OPTIONS).write_bytes(pickle.dumps(options))
        built = FmuBuilder.build_FMU(
            SLAVE,
            folder,
            [folder / each for each in (SCENE, SETTINGS, OPTIONS)],
            canHandleVariableCommunicationStepSize=True,
        )
        shutil.move(built, target)
    return target


def _describe(scene: Scene, simulation: Simulation, name: str, result: object) -> dict[str, Any]:
    """Return an output as data, after its evaluation at the start."""
    if not isinstance(result, tuple) or len(result) != 2:
        raise InputError(
            f"output {name} must be a result and its handle, such as ('position', rod.end), got "
            f"{format_value(result)}"
        )
    what, handle = check_choice(f"result of output {name}", result[0], QUANTITIES), result[1]
    size = np.size(QUANTITIES[what].evaluate(simulation, handle))
    return {"what": what, "of": _refer(scene, handle), "size": size}


def _refer(scene: Scene, handle: Any) -> dict[str, Any]:
    """Return a handle of the scene as data."""
    if isinstance(handle, Point):
        reference: dict[str, Any] = encoded(handle.reference, "an output", {})
        return reference
    name = "joints" if handle in scene.joints else "attachments"
    return {"list": name, "number": getattr(scene, name).index(handle)}


def _check_names(*groups: Iterable[str]) -> None:
    """Refuse names that are not identifiers, or that two variables have."""
    names = [TIME, *(name for group in groups for name in group)]
    for name in names:
        if not isinstance(name, str) or not NAME.fullmatch(name):
            raise InputError(
                "the name of an input or an output of an FMU must have letters, digits and "
                f"underscores, such as 'push', got {format_value(name)}"
            )
        if names.count(name) > 1:
            raise InputError(f"two variables of the FMU are named {name!r}: give one another name")
