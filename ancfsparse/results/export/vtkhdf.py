"""VTKHDF files: moving polylines with values at points and cells.

Format: VTK documentation, "VTKHDF file format", version 2.2, type PolyData with steps.  The
topology is stored once, and every step has the offsets of its points and values.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count, check_flag
from ancfsparse.errors import InputError
from ancfsparse.file_names import check_target
from ancfsparse.results.fields.energy_balance import BLOCK_SIZE
from ancfsparse.results.fields.motion import Motion
from ancfsparse.results.fields.section_forces import axial_forces
from ancfsparse.results.geometry.deformed_shape import trace_elements, trace_slopes
from ancfsparse.results.geometry.scene_outline import Outline, make_outline
from ancfsparse.results.geometry.wireframe import make_wireframe, trace_edges

VERSION = 2, 2
MAX_PIECES = 1000  # straight pieces of an element
CELL_TYPES = "Vertices", "Lines", "Polygons", "Strips"

Forces = Callable[[Vector, Vector, Vector], list[Vector]]
Sizes = NDArray[np.int64]


def write_motion(run: Motion, path: str | Path, per_element: int, progress: bool) -> Path:
    """Write all states of a motion with their axial forces; see `Trajectory.to_vtk`."""
    return write_vtk(
        make_outline(run.system), run.t, run.q, run.v, path,
        per_element=per_element, forces=partial(axial_forces, run.system), progress=progress,
    )  # fmt: skip


def write_vtk(
    outline: Outline,
    t: Vector,
    q: Vector,
    v: Vector,
    path: str | Path,
    *,
    per_element: int = 4,
    forces: Forces | None = None,
    progress: bool = True,
) -> Path:
    """Write coordinates q and velocities v (k, n) at times t (k,) [s]; see `Trajectory.to_vtk`.

    `forces` returns from coordinates, velocities and times the axial forces of every body, each
    (k, n_elements) [N].
    """
    target = check_target("a VTKHDF file", path, (".vtkhdf", ".hdf"))
    pieces = check_count("per_element", per_element)
    if pieces > MAX_PIECES:
        raise InputError(f"per_element must be at most {MAX_PIECES}, got {pieces}")
    check_flag("progress", progress)
    sizes = _sizes(outline, pieces)
    n_cells, n_points = len(sizes), int(sizes.sum())
    rows = max(1, BLOCK_SIZE // (8 * n_points))
    np.asarray(q[0:1])  # fails without all points, before the file is created
    with h5py.File(target, "w", libver=("v108", "v108")) as file:
        root = _root(file, outline, sizes, len(t), forces is not None)
        quiet = None if progress else True  # None: only on a terminal
        with tqdm(total=len(t), unit="state", leave=False, disable=quiet) as bar:
            for i in range(0, len(t), rows):
                block = slice(i, i + rows)
                states = np.asarray(q[block]), np.asarray(v[block])
                _append(root, outline, pieces, i, *states, t[block], forces)
                bar.update(len(states[0]))
        _add_steps(root, t, n_points, n_cells)
    return target


def _root(file: Any, outline: Outline, sizes: Sizes, k: int, with_forces: bool) -> Any:
    """Write the topology, and create data sets for all states."""
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = VERSION
    # VTK reads only texts of fixed length.
    root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", 8))
    n_cells, n_points = len(sizes), int(sizes.sum())
    root["NumberOfPoints"] = np.array([n_points], np.int64)
    for kind in CELL_TYPES:
        group, of_kind = root.create_group(kind), sizes if kind == "Lines" else sizes[:0]
        group["NumberOfCells"] = np.array([len(of_kind)], np.int64)
        group["NumberOfConnectivityIds"] = np.array([of_kind.sum()], np.int64)
        group["Connectivity"] = np.arange(of_kind.sum(), dtype=np.int64)
        group["Offsets"] = np.append(0, np.cumsum(of_kind))
    at_points, of_cells = root.create_group("PointData"), root.create_group("CellData")
    _create_dataset(root, "Points", k * n_points, 3)
    _create_dataset(at_points, "Velocity", k * n_points, 3)
    _create_dataset(at_points, "Strain", k * n_points)
    counts = _counts(outline)
    bodies = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
    radii = np.zeros(len(counts), np.float32)
    radii[: len(outline.parts)] = [part.radius for part in outline.parts]
    at_points["Radius"] = np.repeat(radii[bodies], sizes)
    of_cells["Body"] = bodies
    if with_forces:
        _create_dataset(of_cells, "AxialForce", k * n_cells)
    return root


def _create_dataset(group: Any, name: str, rows: int, columns: int | None = None) -> None:
    shape = (rows,) if columns is None else (rows, columns)
    group.create_dataset(name, shape, np.float32)


def _counts(outline: Outline) -> list[int]:
    """Return the number of lines of every body, rigid bodies last."""
    edges = [len(make_wireframe(solid).edges) for solid in outline.solids]
    return [len(part.lengths) for part in outline.parts] + edges


def _sizes(outline: Outline, pieces: int) -> Sizes:
    """Return the number of points of every line."""
    counts, n = _counts(outline), len(outline.parts)
    return np.repeat(np.array([pieces + 1, 2]), [sum(counts[:n]), sum(counts[n:])])


def _append(
    root: Any,
    outline: Outline,
    pieces: int,
    i: int,
    q: Vector,
    v: Vector,
    t: Vector,
    forces: Forces | None,
) -> None:
    """Write the values at points and elements of states from index i on."""
    points, rates, strains = [], [], []
    for part in outline.parts:
        points.append(_in_space(trace_elements(q, part, pieces)))
        rates.append(_in_space(trace_elements(v, part, pieces)))
        along = np.linalg.norm(trace_slopes(q, part, pieces), axis=-1)
        strains.append(along.reshape(len(q), -1) - 1.0)
    for solid in outline.solids:
        points.append(_in_space(trace_edges(q, solid)))
        rates.append(_in_space(trace_edges(v, solid)))
        strains.append(np.zeros(points[-1].shape[:2]))
    n_points = sum(each.shape[1] for each in points)
    rows_of_points = slice(i * n_points, (i + len(q)) * n_points)
    root["Points"][rows_of_points] = np.concatenate(points, axis=1).reshape(-1, 3)
    root["PointData/Velocity"][rows_of_points] = np.concatenate(rates, axis=1).reshape(-1, 3)
    root["PointData/Strain"][rows_of_points] = np.concatenate(strains, axis=1).ravel()
    if forces is not None:
        n_cells = len(root["CellData/Body"])
        n_elements = sum(len(part.lengths) for part in outline.parts)
        unknown = np.full((len(q), n_cells - n_elements), np.nan)
        along = np.concatenate([*forces(q, v, t), unknown], axis=1)
        root["CellData/AxialForce"][i * n_cells : (i + len(q)) * n_cells] = along.ravel()


def _in_space(lines: Vector) -> Vector:
    """Return points (j, e, p, dim) of all elements with three components, (j, e p, 3)."""
    j, *_, dim = lines.shape
    out = np.zeros((j, lines[0].size // dim, 3))
    out[..., :dim] = lines.reshape(j, -1, dim)
    return out


def _add_steps(root: Any, t: Vector, n_points: int, n_cells: int) -> None:
    """Write the offsets of points and values of every time; constant data have the offset 0."""
    steps, k = root.create_group("Steps"), len(t)
    steps.attrs["NSteps"] = k
    steps["Values"] = t
    number = np.arange(k, dtype=np.int64)
    steps["PointOffsets"] = number * n_points
    steps["PartOffsets"], steps["NumberOfParts"] = 0 * number, np.ones(k, np.int64)
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        steps[name] = np.zeros((k, len(CELL_TYPES)), np.int64)
    for group, size in (("PointData", n_points), ("CellData", n_cells)):
        offsets = steps.create_group(f"{group}Offsets")
        for name in root[group]:
            offsets[name] = number * (size if name not in ("Radius", "Body") else 0)
