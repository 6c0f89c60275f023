"""Checkpoints in files: a run and its state as bytes."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from ancfsparse import integrators, nonlinear
from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.integrators.interface.time_grid import TimeGrid
from ancfsparse.messages import format_value
from ancfsparse.scene import Scene
from ancfsparse.scene.storage.json_file import written
from ancfsparse.solve.motion.arguments import Request
from ancfsparse.solve.preparation.checkpoint_schedule import Schedule
from ancfsparse.system import System
from ancfsparse.system.coordinates.state import CoordinateLayout, State

SIMPLE_ARGUMENTS = (
    *("t_end", "n_steps", "factorization", "tolerance", "max_energy_gain", "max_halvings"),
    *("threads", "save_every", "moved"),
)
"""Fields of a request that are numbers and texts."""
SIZE = struct.Struct("<Q")  # bytes of the text of packed data
METHODS = {
    name: getattr(module, name)
    for module, names in (
        (
            integrators,
            "Newmark HHT GeneralizedAlpha EnergyMomentum CentralDifference RungeKuttaNystrom "
            "DormandPrince",
        ),
        (nonlinear, "Newton ModifiedNewton QuasiNewton"),
    )
    for name in names.split()
}
"""Integrators and solvers that a checkpoint can store, by name."""


def describe_method(method: object) -> Any:
    """Return an integrator or a solver as plain data.

    Raises
    ------
    InputError
        If it is of a class of the user.
    """
    if isinstance(method, str):
        return method
    kind = type(method).__name__
    if METHODS.get(kind) is not type(method):
        raise InputError(
            f"a checkpoint cannot store {format_value(method)}: take one of {', '.join(METHODS)}, "
            "or leave out checkpoint"
        )
    names = [each.name for each in fields(method)]  # type: ignore[arg-type]
    return {"kind": kind} | {name: getattr(method, name) for name in names}


def make_method(data: Any) -> Any:
    """Return the integrator or solver that `describe_method` described."""
    if isinstance(data, str):
        return data
    return METHODS[data["kind"]](**{k: v for k, v in data.items() if k != "kind"})


def describe_state(state: State | None) -> Any:
    """Return a state as plain data and arrays."""
    if state is None:
        return None
    vectors = {name: getattr(state, name) for name in ("q", "v", "a", "lam", "b")}
    return {"t": state.t, "layout": list(state.layout), "memory": state.memory, **vectors}


def make_state(data: Any) -> State | None:
    """Return the state that `describe_state` described."""
    if data is None:
        return None
    bodies, rows, q_ref = data["layout"]
    layout = CoordinateLayout(tuple(bodies), rows, q_ref)
    return State(**data | {"layout": layout})


def describe_request(request: Request, system: System) -> dict[str, Any]:
    """Return a request, with its scene, as plain data and arrays.

    Raises
    ------
    InputError
        If a checkpoint cannot store the integrator or the solver.
    """
    assert request.checkpoint is not None
    try:
        records = written(request.scene)
    except InputError:  # functions that a file cannot distinguish
        records = ""
    return {name: getattr(request, name) for name in SIMPLE_ARGUMENTS} | {
        "clock": [request.clock.begin, request.clock.dt],
        "integrator": describe_method(request.integrator),
        "solver": describe_method(request.solver),
        "start": describe_state(request.state),
        "checkpoint": request.checkpoint.argument,
        "scene": dict(system.description),
        "records": records,
        "shape": system.q_ref,
        "velocities": system.v0,
    }


def make_request(data: Mapping[str, Any], scene: Scene, output: Path, progress: bool) -> Request:
    """Return the request that `describe_request` described, for its scene."""
    integrator = make_method(data["integrator"])
    return Request(
        scene=scene,
        state=make_state(data["start"]),
        clock=TimeGrid(*data["clock"]),
        accuracy=None,
        integrator=integrator,
        named=integrator,
        solver=make_method(data["solver"]),
        save_nodes=None,
        output=output,
        progress=progress,
        checkpoint=Schedule(data["checkpoint"]),
        **{name: data[name] for name in SIMPLE_ARGUMENTS},
    )


def pack(value: Any) -> bytes:
    """Return nested lists and mappings of numbers, texts and arrays as bytes."""
    arrays: list[Vector] = []

    def plain(each: Any) -> Any:
        if isinstance(each, np.ndarray):
            arrays.append(np.ascontiguousarray(each))
            return {"array": [each.dtype.str, list(each.shape)]}
        if isinstance(each, Mapping):
            return {name: plain(inner) for name, inner in each.items()}
        if isinstance(each, list | tuple):
            return [plain(inner) for inner in each]
        return each.item() if isinstance(each, np.generic) else each

    text = json.dumps(plain(value)).encode()
    return b"".join([SIZE.pack(len(text)), text, *(each.tobytes() for each in arrays)])


def unpack(data: memoryview) -> tuple[Any, memoryview]:
    """Return packed data, and the bytes after them."""
    (length,), data = SIZE.unpack(data[: SIZE.size]), data[SIZE.size :]
    text, data = bytes(data[:length]), data[length:]

    def full(each: Any) -> Any:
        nonlocal data
        if isinstance(each, list):
            return [full(inner) for inner in each]
        if not isinstance(each, dict):
            return each
        if set(each) != {"array"}:
            return {name: full(inner) for name, inner in each.items()}
        kind, shape = each["array"]
        size = int(np.prod(shape)) * np.dtype(kind).itemsize
        part, data = data[:size], data[size:]
        return np.frombuffer(part, kind).reshape(shape).copy()

    return full(json.loads(text)), data
