"""The pipeline from the record of a beam to its handle.

1. Stand-ins replace ``"auto"`` arguments (`auto_element`); a slack string gets its own element.
2. The mesh: the number of elements, or the positions of the nodes.
3. The reference shape: straight and uniform (`straight_beam`), or along a curve, strained, twisted
   or tapered (`curved_beam`).
4. An offset of the centroid (`offset_beam`), and eigenstrains (`eigenstrain`).

`gravity` is the acceleration of gravity in the scene [m/s2], shape (dim,).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice, check_reals
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene import meshing
from ancfsparse.scene.bodies.auto_element import AUTO_ELEMENTS, stand_ins
from ancfsparse.scene.bodies.beam import Beam, BeamSpec
from ancfsparse.scene.bodies.element_choice import slack_string
from ancfsparse.scene.meshing.straight_beam import build_straight_beam

RESTS = ("curved", "straight")  # stress-free shapes of a beam along a curve, the default first


def build_beam(record: BeamSpec, gravity: Vector) -> Beam:
    """Check the arguments of a beam and build its handle, which is not yet part of a scene."""
    label, dim = record.name, len(gravity)
    check_choice(f"rest of {label}", record.rest, RESTS)
    element, n_elements, automatic = stand_ins(
        record.element, record.n_elements, "thin" if dim == 2 else "thick", AUTO_ELEMENTS
    )
    if record.slack is not None:
        element = slack_string(label, element, dim, record.slack)
    fractions = None
    if record.nodes is not None:
        fractions = _node_fractions(label, record.nodes, n_elements)
        n_elements = len(fractions) - 1
    definition = replace(record, element=element, n_elements=n_elements, nodes=fractions)
    if _is_straight_and_uniform(definition):
        beam = build_straight_beam(definition, dim)
    else:
        beam = meshing.build_curved_beam(definition, gravity)
    if automatic:
        beam = replace(beam, automatic=automatic)
    if record.offset is not None:
        beam = meshing.offset_from_line(beam, record.offset)
    if record.eigenstrain is not None or record.eigencurvature is not None:
        beam = meshing.with_eigenstrain(beam, record.eigenstrain, record.eigencurvature)
    return beam


def _is_straight_and_uniform(record: BeamSpec) -> bool:
    """Return True for a straight beam of equal elements that is not twisted and free of stress."""
    shape = record.curve, record.length, record.tension, record.twist, record.nodes
    return (
        all(argument is None for argument in shape)
        and not callable(record.up)
        and getattr(record.section, "is_uniform", True)
    )


def _node_fractions(label: str, nodes: ArrayLike, n_elements: int | str | None) -> Vector:
    """Return the positions of the nodes as fractions of the length, (n + 1,)."""
    needed = "fractions of its length that grow from 0 to 1, such as (0, 0.1, 0.3, 1)"
    fractions = check_reals(f"nodes of {label}", nodes, needed)
    if (
        fractions.ndim != 1
        or len(fractions) < 2
        or (fractions[0], fractions[-1]) != (0.0, 1.0)
        or not (np.diff(fractions) > 0.0).all()
    ):
        raise InputError(f"nodes of {label} must be {needed}, got {format_value(nodes)}")
    if n_elements is not None and n_elements != len(fractions) - 1:
        raise InputError(
            f"{label} has {len(fractions)} nodes, which make {len(fractions) - 1} elements, but "
            f"n_elements is {format_value(n_elements)}: leave one of them out"
        )
    return fractions
