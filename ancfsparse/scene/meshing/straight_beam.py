"""Straight uniform beams, built from their records."""

from __future__ import annotations

from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count, check_vector
from ancfsparse.errors import MessageTemplate, Parameter
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.scene.bodies.beam import Beam, BeamSpec
from ancfsparse.scene.bodies.element_choice import (
    check_make,
    chosen_element,
    given_options,
    refuse_in_plane,
)
from ancfsparse.scene.geometry.positions import check_ends
from ancfsparse.scene.geometry.section_frames import along_principal_axes, section_axes
from ancfsparse.scene.meshing.initial_velocity import velocity_field
from ancfsparse.system_memory import check_memory

# Memory of the arrays of a beam [bytes per element], and per element and dimension.
BYTES_PER_ELEMENT = 20.0
BYTES_PER_DIM = 16.0


def build_straight_beam(record: BeamSpec, dim: int) -> Beam:
    """Check the arguments of a straight beam and build its handle."""
    label = record.name
    element, options, kind = chosen_element(label, record.element, dim, given_options(record))
    count = check_count(f"n_elements of {label}", record.n_elements)
    check_make(label, kind, record.section, record.material)
    check_element_memory(label, count, BYTES_PER_DIM * dim + BYTES_PER_ELEMENT)
    tail, head = check_ends(label, record.start, record.end, dim)
    if record.up is not None and dim == 2:
        refuse_in_plane(label, "up")
    up = None if record.up is None else check_vector(f"`up` of {label}", record.up, 3)  # type: ignore[arg-type]
    positions = np.linspace(tail, head, count + 1)
    axes = along_principal_axes(section_axes(head - tail, up, label), record.section)
    length = float(np.linalg.norm(positions[-1] - positions[0]))
    return new_beam(
        record,
        element=element,
        options=options,
        kind=kind,
        positions=positions,
        lengths=np.broadcast_to(length / count, (count,)),
        arcs=np.arange(count + 1, dtype=np.int32) / count * length,
        vectors=axes[None],
        frames=axes[None],
    )


def new_beam(record: BeamSpec, *, positions: Vector, kind: ElementKind, **arrays: Any) -> Beam:
    """Return the handle of a beam with some attributes of `Beam`."""
    rows = np.arange(len(positions), dtype=np.int32)
    return Beam(
        name=record.name,
        kind=kind,
        positions=positions,
        row_nodes=rows,
        ends=np.stack([rows[:-1], rows[1:]], axis=1),
        section=record.section,
        material=record.material,
        n_each=len(rows) - 1,
        velocity=velocity_field(record.name, record.velocity, positions),
        **arrays,
    )


def check_element_memory(label: str, n_elements: int, bytes_per_element: float) -> None:
    """Refuse more elements than fit into memory."""
    fewer = MessageTemplate("a smaller {n_elements}", n_elements=Parameter("n_elements"))
    check_memory(f"{label}, {n_elements} elements,", bytes_per_element * n_elements, fewer)
