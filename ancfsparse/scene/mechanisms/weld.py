"""Welds: two points coincide, without relative rotation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.geometry.section_frames import normals
from ancfsparse.scene.joints.frame_vectors import (
    direction,
    equate,
    make_orthogonal,
    row_of,
    vectors_of,
)
from ancfsparse.scene.joints.joint import Mark
from ancfsparse.scene.kinematics.linear_forms import LinearForm, Vector
from ancfsparse.scene.mechanisms.two_body_joint import TwoBodyJoint

VECTOR_NAMES = ("r_x", "r_y", "r_z")
# Sine of the angle between two slopes below which they are in line.
MAX_SINE_IN_LINE = 1e-9


@dataclass(frozen=True, eq=False)
class Weld(TwoBodyJoint):
    """Two points coincide, without relative rotation.

    At beams it holds what a clamp holds, to a wall that may move.

    Attributes
    ----------
    stretch : str
        ``"free"`` or ``"fixed"``, of beams.
    """

    stretch: str = "free"
    name = "weld"

    @property
    def mark(self) -> Mark | None:
        """How pictures show it: as a clamp where it holds a point to the ground."""
        if self.b is not None:
            return None
        return Mark("clamp", self.a.beam.interior_direction(self.a))

    def lower(self, builder: ConstraintBuilder) -> None:
        """Share the point, and the directions that both have."""
        self._share_point(builder)
        beams = [node for node in self.nodes if node.beam.n_elements]
        if not beams:
            self._share_frame(builder)
            return
        held = beams[0]
        wall = next((node for node in self.nodes if node is not held), None)
        if wall is not None and builder.kind(wall).is_cable and wall.beam.n_elements:
            held, wall = wall, held
        self._hold(builder, held, wall)

    def _hold(self, builder: ConstraintBuilder, held: Point, wall: Point | None) -> None:
        """Hold the directions of a node of a beam to a wall, which may move."""
        kind, frame = builder.kind(held), held.frame
        if wall is not None and wall.beam.n_elements and self._needs_stiff_section(held, wall):
            self._stiffen(builder, wall)
        if kind.is_cable and self.stretch == "free":
            tangent = frame[0] / np.linalg.norm(frame[0])
            for k, normal in enumerate(normals(tangent)):
                label = f"{self.label}, direction {k + 1}"
                beside = self._beside(builder, wall, normal)
                make_orthogonal(
                    builder, label, direction(builder, held, tangent), beside, self.size
                )
            return
        row = row_of(builder, held)
        for name, vector in zip(("r_x", "r_y", "r_z"), frame, strict=False):
            if name in kind.section or (name == "r_x" and self.stretch == "fixed"):
                own = LinearForm.of([row[kind.columns(name)]], [1.0])
                beside = self._beside(builder, wall, vector)
                equate(builder, f"{self.label}, {name}", own, beside, self.size, self.size)

    @staticmethod
    def _needs_stiff_section(held: Point, wall: Point) -> bool:
        """Whether a slope of one beam follows section vectors of another, which has some."""
        if wall.beam.kind.is_cable or held.beam.kind.is_cable:
            return not wall.beam.kind.is_cable
        slope, section = held.frame[0], wall.frame[1:]
        sizes = np.linalg.norm(slope) * np.linalg.norm(section, axis=1)
        return bool((np.abs(section @ slope) > MAX_SINE_IN_LINE * sizes).any())

    def _stiffen(self, builder: ConstraintBuilder, wall: Point) -> None:
        """Keep lengths and angles of the vectors of a node.

        Otherwise the last element alone bears the moment that turns a slope against a section, by a
        shear that grows as elements become shorter.
        """
        frame, vectors = wall.frame, vectors_of(builder, wall)
        assert isinstance(wall.beam, ElasticBody)
        mass = float(np.mean(wall.beam.stiffnesses()["mass_per_length"])) * wall.beam.size
        for k, (u, mine) in enumerate(zip(vectors, frame, strict=True)):
            for j, (v, its) in enumerate(zip(vectors[: k + 1], frame, strict=False)):
                factor = 0.5 * self.size if j == k else self.size
                label = f"rigidity of {wall!r}, {VECTOR_NAMES[j]}.{VECTOR_NAMES[k]}"
                terms = ((factor, a, b) for a, b in zip(u, v, strict=True))
                builder.equation(label, -factor * float(mine @ its), *terms, size=factor, mass=mass)

    @staticmethod
    def _beside(builder: ConstraintBuilder, wall: Point | None, vector: Vector) -> LinearForm:
        return LinearForm.fixed(vector) if wall is None else direction(builder, wall, vector)
