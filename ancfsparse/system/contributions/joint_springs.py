"""Springs, stops and friction in joints."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ancfsparse.dispatch import compiled
from ancfsparse.scene.joint_springs import JointSpring
from ancfsparse.scene.joints.freedoms import measure
from ancfsparse.system.contributions.couplings import flat
from ancfsparse.system.contributions.interface import Compiled, Contribution, Vector, unknowns
from ancfsparse.system.lowering import Lowering
from ancfsparse.system.pattern import Pattern, Unknowns

if TYPE_CHECKING:
    from ancfsparse.system.system import System


class JointSprings(Contribution):
    """What acts along the freedoms of the joints of a system."""

    pushes = True

    def __init__(self, system: System, springs: list[JointSpring]) -> None:
        self._n_free, self._springs = system.n_free, springs
        lowering = Lowering(system.scene, system.kinds)
        final = np.empty(lowering.n_raw, dtype=np.int32)
        for raw, places in zip(lowering.raw, system.places, strict=True):
            final[raw] = places
        self._measures = [measure(lowering, s.joint, s.of).placed(final) for s in springs]

    def cliques(self) -> list[Unknowns]:
        """Return the coordinates of each measure, (1, m)."""
        return [unknowns(each.place.copy(), self._n_free)[None] for each in self._measures]

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled springs."""
        slots = [pattern.slots(each).ravel() for each in self.cliques()]
        columns = {
            name: np.array([getattr(each, name) for each in self._springs], dtype=float)
            for name in ("low", "high", "stiffness", "damping", "slip")
        }
        made: Compiled = compiled("joint_springs").JointSprings(
            flat(self._measures)
            | columns
            | {
                "law": np.array([each.law for each in self._springs], dtype=np.int32),
                "slot": np.concatenate(slots),
                "first_slot": np.cumsum([0, *(len(each) for each in slots)], dtype=np.int32),
            }
        )
        return made

    def holds(self, q: Vector) -> Any:
        """Return the gradient of the measure of each spring, which resists its change."""
        import scipy.sparse as sp

        found = [m for m, s in zip(self._measures, self._springs, strict=True) if s.stiffness]
        if not found:
            return None
        values = np.concatenate([each.gradients(q[None])[0] for each in found])
        rows = np.repeat(np.arange(len(found)), [len(each.place) for each in found])
        places = (rows, np.concatenate([each.place for each in found]))
        return sp.csr_array((values, places), shape=(len(found), len(q)))


def of(system: System) -> list[JointSprings]:
    """Return what acts along the freedoms of the joints of a system."""
    springs = [each for each in system.scene.attached if isinstance(each, JointSpring)]
    return [JointSprings(system, springs)] if springs else []
