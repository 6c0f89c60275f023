"""Runs as tables with names and units: a data frame of pandas, a dataset of xarray."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results.fields.energy_balance import ENERGIES
from ancfsparse.results.fields.motion import UNITS, Motion
from ancfsparse.results.fields.quantities import (
    QUANTITIES,
    components_of,
    evaluate_history,
    evaluate_quantity,
    select_states,
    unit_of,
)
from ancfsparse.scene import Beam, Body, ElasticBody, Point, check_point

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

ADVICE = "which is not installed: pip install 'ancfsparse[data]', or take run.to_csv()"
LEVELS = "quantity", "point", "component"
AXES = "x", "y", "z"


def make_frame(
    run: Motion, points: Sequence[Point] | None, quantities: Sequence[str]
) -> pd.DataFrame:
    """Return a data frame; see `Trajectory.to_pandas`."""
    try:
        import pandas as pd
    except ImportError as missing:
        raise InputError(f"a data frame needs pandas, {ADVICE}") from missing
    if points is None:
        points = [body.default_point for body in run.system.scene.bodies if body.default_point]
    for what, values, example in (
        ("points", points, "[rod.end]"), ("quantities", quantities, "['position']")
    ):  # fmt: skip
        if not isinstance(values, (list, tuple)) or not values:
            raise InputError(f"{what} must be a list such as {example}, got {format_value(values)}")
    columns: dict[tuple[str, str, str], Vector] = {}
    for what in quantities:
        for point in points:
            history = evaluate_history(run, point, what)
            for column, name in components_of(history, what, check_point("a table", point).beam):
                columns[what, repr(point), name] = column
    frame = pd.DataFrame(columns, index=pd.Index(run.t, name="time [s]"))
    frame.columns.names = list(LEVELS)
    frame.attrs["units"] = {what: unit_of(what) for what in quantities}
    return frame


def make_dataset(run: Any, quantities: Sequence[str]) -> xr.Dataset:
    """Return a dataset; see `Trajectory.to_xarray`."""
    try:
        import xarray as xr
    except ImportError as missing:
        raise InputError(f"a dataset needs xarray, {ADVICE}") from missing
    if not isinstance(quantities, (list, tuple)):
        raise InputError(
            f"quantities must be a list such as ['position', 'N'], got {format_value(quantities)}"
        )
    for what in quantities:
        check_choice("quantity", what, ("position", "velocity", "acceleration", *QUANTITIES))
    energies = np.stack([getattr(run.energy, name) for name in ENERGIES], axis=1)
    tables: dict[str, Any] = {"energy": (("time", "form"), energies, {"units": "J"})}
    labels: dict[str, Any] = {
        "time": ("time", run.t, {"units": "s"}),
        "form": list(ENERGIES),
        "axis": list(AXES[: run.system.scene.dim]),
    }
    for body in run.system.scene.bodies:
        for what in quantities:
            if what in UNITS:
                tables[f"{body.name} {what}"] = _nodal_motion(run, body, what)
            elif isinstance(body, ElasticBody) and not _is_missing(what, body):
                tables[f"{body.name} {what}"] = _mid_values(run, body, what)
        if isinstance(body, Beam):
            arcs = np.cumsum([0.0, *body.lengths])
            middles = 0.5 * (arcs[1:] + arcs[:-1])
            labels[f"{body.name} s"] = f"{body.name} node", arcs, {"units": "m"}
            labels[f"{body.name} s of elements"] = f"{body.name} element", middles, {"units": "m"}
    settings = {name: "" if x is None else x for name, x in run.settings.items()}
    return xr.Dataset(tables, labels, {**settings, "method": run.stats.solver})


def _nodal_motion(run: Motion, body: Body, what: str) -> tuple[Any, Vector, dict[str, str]]:
    """Return the motion of all nodes of a body, or of the origin of a rigid one."""
    table = {"position": run.q, "velocity": run.v, "acceleration": run.a}[what]
    nodes = [body.node(k) for k in range(body.n_nodes)]
    indices, weights = zip(*map(run.system.point, nodes), strict=True)
    values = np.einsum("jndp,np->jnd", np.asarray(table[..., np.stack(indices)]), np.stack(weights))
    units = {"units": UNITS[what]}
    if not body.n_elements:
        return ("time", "axis"), values[:, 0], units
    return ("time", f"{body.name} node", "axis"), values, units


def _mid_values(run: Motion, body: ElasticBody, what: str) -> tuple[Any, Vector, dict[str, str]]:
    """Return a quantity in the middle of all elements, in components along the last axis."""
    values = evaluate_quantity(run.system, select_states(run), what, body)
    names = ["time", f"{body.name} element"]
    if values.ndim > 2:
        # Vectors in space have the axes of space, those of thick beams the axes of their section.
        names.append("axis" if body.kind.is_cable else f"{body.name} {what} component")
    title, unit = QUANTITIES[what]
    return tuple(names), values, {"units": unit, "long_name": title}


def _is_missing(what: str, body: ElasticBody) -> bool:
    """Return True for the torsion of a body that has none."""
    return what == "T" and (body.dim == 2 or body.kind.is_cable)
