"""Forces and strains as quantities: reactions, section forces, axial strains."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.plans.quantities.quantity import (
    ROUNDING_RATIO,
    AtPoint,
    check_beam_point,
    position_rounding,
    relative_rounding,
)
from ancfsparse.results import Trajectory
from ancfsparse.scene import Point, Scene, check_point

PARTS = ("N", "Q", "M", "T")
FORCE_ROUNDING_RATIO = 1e-13  # of forces over stiffness times coordinates; beams at rest have 4e-14


class Reaction(AtPoint):
    """Quantity returned by `reaction`."""

    label: ClassVar[str] = "reaction at"
    unit: ClassVar[str] = "N"
    is_like_rates: ClassVar[bool] = True
    is_expensive: ClassVar[bool] = True
    has_limit_at_start: ClassVar[bool] = False
    needs_equations: ClassVar[bool] = True

    def check(self, scene: Scene) -> None:
        """Refuse a point without a joint."""
        super().check(scene)
        if not any(self.point in joint.nodes for joint in scene.joints):
            raise InputError(
                f"the scene does not have the {self.name}: no joint holds that point; take a "
                "point with a pin, a clamp or a rod"
            )

    def history(self, run: Trajectory) -> Vector:
        """Return forces (k, dim) [N]."""
        return run.reaction(self.point)

    def rounding(self, run: Trajectory) -> float:
        """Return the size up to which it consists of rounding errors [N]."""
        return _force_rounding(self, run)


@dataclass(frozen=True, eq=False, repr=False)
class SectionForceAt(AtPoint):
    """Quantity returned by `section_force`."""

    is_like_rates: ClassVar[bool] = True
    has_limit_at_start: ClassVar[bool] = False
    part: str = "M"

    def __post_init__(self) -> None:
        """Check the part."""
        super().__post_init__()
        check_choice("part of a section force", self.part, PARTS)

    @property
    def is_moment(self) -> bool:
        """True for moments."""
        return self.part in "MT"

    @property
    def unit(self) -> str:  # type: ignore[override]
        """Unit: N, or N m for moments."""
        return "N m" if self.is_moment else "N"

    @property
    def label(self) -> str:  # type: ignore[override]
        """Name without the point."""
        return f"section force {self.part} at"

    def order(self, position_order: int) -> int:
        """Return the order: moments need two derivatives, shear three; tension is constant."""
        return min(position_order, 2 if self.is_moment else 1)

    def history(self, run: Trajectory) -> Vector:
        """Return components (k, m) [N, N m]."""
        values = getattr(run.section_force(self.beam, [self.point]), self.part)
        if values is None:
            raise InputError(
                f"{self.point.beam.name} has an element without torsion: take N, Q or M, or "
                "element='thick'"
            )
        return np.asarray(values).reshape(len(run.t), -1)

    def rounding(self, run: Trajectory) -> float:
        """Return the size up to which it consists of rounding errors [N, N m]."""
        return _force_rounding(self, run, self.is_moment)


class Strain(AtPoint):
    """Quantity returned by `strain`."""

    label: ClassVar[str] = "strain at"
    unit: ClassVar[str] = ""
    is_like_rates: ClassVar[bool] = True
    is_axial_strain: ClassVar[bool] = True
    rounding = relative_rounding

    def order(self, position_order: int) -> int:
        """Return the order: axial strains are mean values over an element."""
        return min(position_order, 2)

    def history(self, run: Trajectory) -> Vector:
        """Return strains (k, 1) [-]."""
        return run.strain(self.beam, [self.point])


def _force_rounding(quantity: AtPoint, run: Trajectory, moment: bool = False) -> float:
    """Return the size up to which forces, or moments, are rounding errors [N, N m]."""
    system = run.system
    is_position = np.isin(np.arange(system.n_free), system.positions)
    stiffness = np.abs(system.stiffness_diagonal(system.q_ref))[is_position != moment]
    arm = 1.0 if moment else position_rounding(quantity, run) / ROUNDING_RATIO
    return FORCE_ROUNDING_RATIO * arm * float(np.max(stiffness, initial=0.0))


def reaction(point: Point, *, at: str = "saved") -> Reaction:
    """Return the force of joints at a node [N]; parameters and errors as in `position`."""
    return Reaction(check_point("a reaction", point), at=at)


def strain(point: Point, *, at: str = "saved") -> Strain:
    """Return the axial strain at a point [-]; parameters and errors as in `position`."""
    return Strain(check_beam_point("a strain", point), at=at)


def section_force(point: Point, part: str = "M", *, at: str = "saved") -> SectionForceAt:
    """Return a force or moment in a section as a quantity of interest [N, N m].

    Parameters
    ----------
    point : Point
        A point of a beam.
    part : {"N", "Q", "M", "T"}, optional
        Axial force, shear force, bending moment or torsional moment, see
        `Trajectory.section_force`.
    at : {"saved", "end", "largest"}, optional
        As in `position`.
    """
    return SectionForceAt(check_beam_point("a section force", point), part, at=at)
