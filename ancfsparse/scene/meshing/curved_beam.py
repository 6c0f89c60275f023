"""Beams along a curve, strained, twisted, tapered or with unequal elements, from their records."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count
from ancfsparse.errors import InputError
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.scene.bodies.beam import Beam, BeamSpec
from ancfsparse.scene.bodies.element_choice import (
    check_make,
    chosen_element,
    curved_kind,
    given_options,
    refuse_in_plane,
)
from ancfsparse.scene.geometry.positions import MAX_COORDINATE, check_ends, place
from ancfsparse.scene.geometry.section_frames import along_principal_axes
from ancfsparse.scene.geometry.section_frames_along import frames_along
from ancfsparse.scene.meshing.initial_stretch import initial_shape, lateral_contraction
from ancfsparse.scene.meshing.straight_beam import check_element_memory, new_beam

# Memory of the arrays of a beam [bytes per element], and per element and squared dimension.
BYTES_PER_ELEMENT = 400.0
BYTES_PER_SQUARED_DIM = 64.0


def build_curved_beam(record: BeamSpec, gravity: Vector) -> Beam:
    """Check the arguments of a beam that is not straight and uniform, and build its handle."""
    label, dim = record.name, len(gravity)
    element, options, kind = chosen_element(label, record.element, dim, given_options(record))
    count = check_count(f"n_elements of {label}", record.n_elements)
    check_make(label, kind, record.section, record.material)
    check_element_memory(label, count, BYTES_PER_SQUARED_DIM * dim**2 + BYTES_PER_ELEMENT)
    _check_directions(record, element, kind)
    path, natural, stretch = initial_shape(record, element, options, gravity)
    contraction = lateral_contraction(label, stretch, record.material.poisson_ratio, kind)
    if _is_stress_free_curved(record) and not kind.is_string:
        kind = curved_kind(label, element, kind)
    nodes = record.nodes
    fractions = np.arange(count + 1) / count if nodes is None else np.asarray(nodes)
    s = fractions * path.length
    positions, tangents = path.at(s)
    if record.curve is None:  # as given, without rounding
        positions[[0, -1]] = check_ends(label, record.start, record.end, dim)
    _check_range(label, positions)
    lengths = np.full(count, natural / count) if nodes is None else np.diff(fractions) * natural
    if kind.is_string and record.curve is not None and record.length is None:
        lengths = np.linalg.norm(np.diff(positions, axis=0), axis=1) / stretch
    arcs = np.concatenate([[0.0], np.cumsum(lengths)])
    arcs[-1] = arcs[-1] if kind.is_string else natural
    frames = frames_along(label, path, s, tangents, record.up, record.twist)
    frames = along_principal_axes(frames, record.section)
    vectors = stretch * frames
    if not kind.is_cable:
        vectors[:, 1:] = contraction * frames[:, 1:]
    return new_beam(
        record,
        element=element,
        options=options,
        kind=kind,
        positions=positions,
        lengths=lengths,
        arcs=arcs,
        vectors=vectors,
        frames=frames,
        nodes=None if nodes is None else tuple(fractions.tolist()),
    )


def _check_directions(record: BeamSpec, element: str, kind: ElementKind) -> None:
    """Refuse directions of the section where the element has none."""
    if kind.dim == 2:
        for argument in ("up", "twist"):
            if getattr(record, argument) is not None:
                refuse_in_plane(record.name, argument)
    if (kind.is_cable or kind.is_string) and record.twist is not None:
        raise InputError(
            f"{record.name} is made of {element!r}, which has no torsion and no section to twist: "
            "leave `twist` out or take 'thick'"
        )


def _is_stress_free_curved(record: BeamSpec) -> bool:
    """Return True if the stress-free shape is curved or twisted."""
    curved = record.rest == "curved"
    if record.curve is None and record.twist is None and not callable(record.up):
        return False
    if curved and (record.length is not None or record.tension is not None):
        argument = "length" if record.tension is None else "tension"
        raise InputError(
            f"{record.name} follows a curve in which it is free of stress, so `{argument}` "
            "contradicts it: leave that out, or give rest='straight'"
        )
    return curved


def _check_range(label: str, positions: Vector) -> None:
    """Refuse positions whose squares leave the range of numbers."""
    if not np.abs(positions).max() <= MAX_COORDINATE:
        raise InputError(
            f"{label} reaches beyond {MAX_COORDINATE:g} m, to "
            f"{place(positions[np.argmax(np.abs(positions).max(axis=1))])}; give positions in "
            "metres"
        )
