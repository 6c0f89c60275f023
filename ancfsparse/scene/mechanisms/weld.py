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
from ancfsparse.scene.kinematics.linear_forms import LinearForm
from ancfsparse.scene.mechanisms.two_body_joint import TwoBodyJoint

VECTOR_NAMES = ("r_x", "r_y", "r_z")
MAX_SINE_IN_LINE = 1e-9  # of the angle between two slopes


@dataclass(frozen=True, eq=False)
class Weld(TwoBodyJoint):
    """Two points coincide, without relative rotation.

    At beams it has the constraints of a clamp, relative to a wall that may move.

    Attributes
    ----------
    stretch : str
        As in `Scene.weld`.
    """

    stretch: str = "free"
    name = "weld"

    @property
    def mark(self) -> Mark | None:
        """Symbol in pictures: a clamp if it fixes a point to the ground."""
        if self.b is not None:
            return None
        return Mark("clamp", self.a.beam.interior_direction(self.a))

    def lower(self, builder: ConstraintBuilder) -> None:
        """Share the point and the common directions."""
        self._share_point(builder)
        beams = [point for point in self.nodes if point.beam.n_elements]
        if not beams:
            self._share_frame(builder)
            return
        node = beams[0]
        wall = next((point for point in self.nodes if point is not node), None)
        if wall is not None and builder.kind(wall).is_cable and wall.beam.n_elements:
            node, wall = wall, node
        self._fix_directions(builder, node, wall)

    def _fix_directions(self, builder: ConstraintBuilder, node: Point, wall: Point | None) -> None:
        """Fix the directions of a node of a beam relative to a wall, which may move."""
        kind, frame = builder.kind(node), node.frame
        if wall is not None and wall.beam.n_elements and self._needs_stiff_section(node, wall):
            self._stiffen(builder, wall)
        if kind.is_cable and self.stretch == "free":
            tangent = frame[0] / np.linalg.norm(frame[0])
            for k, normal in enumerate(normals(tangent)):
                label = f"{self.label}, direction {k + 1}"
                wall_normal = direction(builder, wall, normal)
                make_orthogonal(
                    builder, label, direction(builder, node, tangent), wall_normal, self.arm
                )
            return
        row = row_of(builder, node)
        for name, vector in zip(VECTOR_NAMES, frame, strict=False):
            if name in kind.section or (name == "r_x" and self.stretch == "fixed"):
                vector_of_beam = LinearForm.of([row[kind.columns(name)]], [1.0])
                vector_of_wall = direction(builder, wall, vector)
                label = f"{self.label}, {name}"
                equate(builder, label, vector_of_beam, vector_of_wall, self.arm, self.arm)

    @staticmethod
    def _needs_stiff_section(node: Point, wall: Point) -> bool:
        """Return True if a slope of one beam rotates with section vectors of the other."""
        if wall.beam.kind.is_cable or node.beam.kind.is_cable:
            return not wall.beam.kind.is_cable
        slope, section = node.frame[0], wall.frame[1:]
        sizes = np.linalg.norm(slope) * np.linalg.norm(section, axis=1)
        return bool((np.abs(section @ slope) > MAX_SINE_IN_LINE * sizes).any())

    def _stiffen(self, builder: ConstraintBuilder, wall: Point) -> None:
        """Keep the lengths and angles of the vectors of a node constant.

        Otherwise the last element alone carries the moment between the slope and the section, by a
        shear strain that grows as elements become shorter.
        """
        frame, vectors = wall.frame, vectors_of(builder, wall)
        assert isinstance(wall.beam, ElasticBody)
        mass = float(np.mean(wall.beam.stiffnesses()["mass_per_length"])) * wall.beam.size
        for k, (u, first) in enumerate(zip(vectors, frame, strict=True)):
            for j, (v, second) in enumerate(zip(vectors[: k + 1], frame, strict=False)):
                factor = 0.5 * self.arm if j == k else self.arm
                label = f"rigidity of {wall!r}, {VECTOR_NAMES[j]}.{VECTOR_NAMES[k]}"
                terms = ((factor, a, b) for a, b in zip(u, v, strict=True))
                builder.equation(
                    label, -factor * float(first @ second), *terms, size=factor, mass=mass
                )
