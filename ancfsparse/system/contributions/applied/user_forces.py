"""User forces, as functions of the motion."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from ancfsparse.array_types import Indices, Integers, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import LoadError
from ancfsparse.scene.force_elements.user_forces import Force
from ancfsparse.scene.records.compiled_callbacks import get_capsule
from ancfsparse.system.assembly.assembly_protocol import CompiledAssembly
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import Compiled, Contribution
from ancfsparse.system.contributions.point_weights import PointSums
from ancfsparse.system.coordinates.discretization import Discretization
from ancfsparse.system.loads.amplitudes import TimeAmplitude

# Displacement over the element length, and velocity over that of waves.  As for differences: with a
# thousandth of it rounding hides a coupling of 3e-5 of the stiffness at 10 m from the origin.
MOVE_RATIO = 6e-6
# Rounding of positions in a force, over their number and the rounding of the largest: measured 13
# in five laws of 2 to 200 points, 0.1 m to 3 km from the origin, with elements of 1 mm to 3 m.
ROUNDING_UNITS = 16.0


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
        slots = self._points.slots(pattern, self._n_free, self._force.coupled)
        self._compiled = self._compile(self._points, slots)
        return self._compiled

    def _compile(self, points: PointSums, slots: Integers) -> CompiledForce:
        """Return the compiled force, for points as sums of some coordinates."""
        compiled: CompiledForce = compiled_module("forces").UserForce(
            points.start,
            points.place,
            points.weight,
            slots,
            self._clock,
            self._force.coupled,
            self._length,
            self._speed,
            get_capsule(self._force.function),
            self._force.checked,
            self._failed,
        )
        return compiled

    def omitted_coupling(self, q: Vector, amplitudes: Vector) -> str:
        """Return a sentence if the force on a point depends on others and is not `coupled`.

        For each binary digit of the numbers of points, those with 0 and those with 1 move in turn,
        so of any two points each once stays while the other moves.
        """
        force, points = self._force, self._points
        dim, k = len(points.place), len(force.points)
        if force.coupled or k == 1:
            return ""
        start, own = np.arange(k + 1, dtype=np.int32), np.arange(dim * k, dtype=np.int32)
        alone = PointSums(start, np.ascontiguousarray(own.reshape(k, dim).T), np.ones(k))
        parts = [self._compile(alone, np.empty(0, dtype=np.int32))]
        pattern, zero = np.arange(dim * k + 1), np.zeros(dim * k)
        assembly: CompiledAssembly = compiled_module("assembly").Assembly(
            dim * k, dim * k, len(amplitudes), pattern, parts
        )
        positions = np.add.reduceat(points.weight * q[points.place], points.start[:-1], axis=1).T
        random = np.random.default_rng(0)

        def forces(moves: Vector) -> Vector:
            state = (positions + self._length * moves).ravel(), (self._speed * moves).ravel()
            r = assembly.residual(*state, zero, zero[:0], zero, amplitudes)[0]
            assembly.check()
            return np.array(r).reshape(k, dim)

        before = forces(np.zeros((k, dim)))
        rounding = ROUNDING_UNITS * np.finfo(float).eps
        ratio = rounding * k * np.max(np.abs(positions)) / (MOVE_RATIO * self._length)
        for digit in range((k - 1).bit_length()):
            for value in (0, 1):
                stays = (start[:k] >> digit) % 2 == value
                moves = MOVE_RATIO * random.standard_normal((k, dim)) * ~stays[:, None]
                change = np.linalg.norm(forces(moves) - before, axis=1)
                at = int(np.argmax(np.where(stays, change, 0.0)))
                limit = ratio * np.max(change) + rounding * np.max(np.abs(before))
                if stays[at] and change[at] > limit:
                    largest = self._length * np.max(np.abs(moves))
                    return (
                        f"{force.what} is not coupled, but at {force.points[at]!r} it changes by "
                        f"{change[at]:.3g} N when other points alone move, by up to {largest:.3g} "
                        "m. The stiffness lacks this: give coupled=True"
                    )
        return ""

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
