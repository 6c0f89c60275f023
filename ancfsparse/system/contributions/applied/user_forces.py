"""User forces, as functions of the motion."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from ancfsparse.array_types import Indices, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import LoadError
from ancfsparse.scene.force_elements.user_forces import Force
from ancfsparse.scene.records.compiled_callbacks import get_capsule
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import Compiled, Contribution
from ancfsparse.system.contributions.point_weights import PointSums
from ancfsparse.system.coordinates.discretization import Discretization
from ancfsparse.system.loads.amplitudes import TimeAmplitude


class CompiledForce(Compiled, Protocol):
    """A user function as a contribution (_user_forces.pyx)."""

    def power(self, q: Vector, v: Vector, amplitudes: Vector, /) -> float:
        """Return the power of the force in a state [W]."""


class UserForceContribution(Contribution):
    """A force of a system by a user function."""

    is_load = True
    conservative = False
    is_explicit_in_time = False

    def __init__(self, system: Discretization, force: Force, clock: int) -> None:
        self._n_free, self._force, self._clock = system.n_free, force, clock
        self._points = PointSums.of(system, [[(1.0, node)] for node in force.points])
        bodies = [node.beam for node in force.points]
        # Scales of small motions: an element, and the wave speed of its material.
        self._length = min(each.shortest for each in bodies)
        waves = [each.speed for each in bodies if each.speed is not None]
        # Without waves: the speed of free fall along its size.
        fall_speed = math.sqrt(self._length * float(np.linalg.norm(system.scene.gravity)))
        self._speed = max(waves, default=fall_speed or self._length)
        self._compiled: CompiledForce

    def cliques(self) -> list[Indices]:
        """Return the coordinates of each point, or of all of them."""
        return self._points.cliques(self._n_free, self._force.coupled)

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled force."""
        points = self._points
        self._compiled = compiled_module("forces").UserForce(
            points.start,
            points.place,
            points.weight,
            points.slots(pattern, self._n_free, self._force.coupled),
            self._clock,
            self._force.coupled,
            self._length,
            self._speed,
            get_capsule(self._force.function),
            self._force.checked,
            self._failed,
        )
        return self._compiled

    def power(self, q: Vector, v: Vector, amplitudes: Vector) -> Vector:
        """Return the power of the force, shape (k,) [W]."""
        return np.array(
            [
                self._compiled.power(*map(np.ascontiguousarray, state))
                for state in zip(q, v, amplitudes, strict=True)
            ]
        )

    def unilateral_forces(
        self, q: Vector, v: Vector, amplitudes: Vector
    ) -> list[tuple[str, Vector]]:
        """Return its power, the only output of a C function."""
        return [(f"the power of {self._force.what} [W]", self.power(q, v, amplitudes))]

    def _failed(self, t: float, status: int) -> LoadError:
        """Return the error for a nonzero status of a C function, or a force that is not finite."""
        reason = f"it returned {status}" if status else "a force is not finite"
        return self._force.failure(t, reason)


def of(system: Discretization) -> list[UserForceContribution]:
    """Return the user forces of a system."""
    found = [each for each in system.scene.attachments if isinstance(each, Force)]
    if not found:
        return []
    clock = system.loads.n_amplitudes
    system.loads.sources.append(TimeAmplitude())
    return [UserForceContribution(system, each, clock) for each in found]
