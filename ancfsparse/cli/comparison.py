"""The command ``ancfsparse compare``: differences of two runs."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Annotated, cast

import numpy as np
import typer

from ancfsparse.array_types import Vector
from ancfsparse.results import Trajectory
from ancfsparse.results.hdf5_reader import load
from ancfsparse.scene import Beam


def compare(
    one: Annotated[Path, typer.Argument(help="File of a run.")],
    other: Annotated[Path, typer.Argument(help="File of another run.")],
) -> None:
    """Compare two runs: their scenes and settings, distances of nodes, and axial forces."""
    runs = load(one), load(other)
    for what in ("scene", "settings"):
        before, after = (_describe(run, what) for run in runs)
        changes = [
            line
            for line in difflib.unified_diff(before, after, n=0, lineterm="")
            if not line.startswith(("---", "+++", "@@"))
        ]
        typer.echo(f"{what}: {'equal' if not changes else ''}".rstrip())
        for line in changes:
            typer.echo(f"  {line}")
    t = runs[0].t[runs[0].t <= runs[1].t[-1] * (1.0 + 1e-12)]
    times = t[t >= runs[1].t[0]]
    again = runs[1].resample(np.minimum(times, runs[1].t[-1]))
    is_common = np.isin(runs[0].t, times)
    bodies = {body.name: body for body in again.system.scene.bodies}
    for body in runs[0].system.scene.bodies:
        if body.name not in bodies:
            typer.echo(f"{body.name}: in {one} alone")
            continue
        here = _nodes(runs[0], body.name)[is_common]
        there = _nodes(again, body.name)
        if here.shape != there.shape:
            typer.echo(f"{body.name}: with other nodes")
            continue
        distances = np.linalg.norm(here - there, axis=-1)
        row, node = np.unravel_index(np.argmax(distances), distances.shape)
        typer.echo(
            f"{body.name}: largest distance {distances[row, node]:.4g} m, of node {node} "
            f"at t = {times[row]:.4g} s"
        )
        if isinstance(body, Beam):
            ranges = [run.range("N", cast(Beam, run.system.scene.body(body.name))) for run in runs]
            texts = [f"{each.min.min():.4g} N to {each.max.max():.4g} N" for each in ranges]
            typer.echo(f"  axial forces from {' and from '.join(texts)}")


def _describe(run: Trajectory, what: str) -> list[str]:
    if what == "scene":
        return str(run.system.scene).splitlines()
    return [f"{name}: {value}" for name, value in run.settings.items() if name != "output"]


def _nodes(run: Trajectory, name: str) -> Vector:
    """Return the positions of the nodes of a body, of a rigid one its origin, (k, n, dim) [m]."""
    body = run.system.scene.body(name)
    return np.stack([run.position(body.node(k)) for k in range(body.n_nodes)], axis=1)
