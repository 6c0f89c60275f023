"""The task of an error-controlled run, which all candidates share."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from ancfsparse.array_types import Vector
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.error_models.modal_spectrum import ModalSpectrum
from ancfsparse.solve.stepping.sampled_states import SampledStates
from ancfsparse.system import System


@dataclass(frozen=True)
class MotionTask:
    """A motion to compute to an accuracy.

    Attributes
    ----------
    system : System
        The moving system.
    t : (k,) float
        Output times from the start on [s].
    accuracy : float
        Largest error of the position of a node at these times [m].
    max_energy_gain : float
        As in `simulate`.
    watch : callable
        Called with the states of a run whenever more are known.
    """

    system: System
    t: Vector
    accuracy: float
    max_energy_gain: float
    watch: Callable[[SampledStates], None]

    @property
    def length(self) -> float:
        """Duration of the motion [s]."""
        return float(self.t[-1] - self.t[0])

    @cached_property
    def discontinuities(self) -> LoadDiscontinuities:
        """Discontinuities of the loads."""
        return LoadDiscontinuities(self.system, float(self.t[0]), float(self.t[-1]))

    @property
    def has_contact(self) -> bool:
        """True if motions may have impacts, where errors are not smooth functions of the step."""
        return any(term.is_contact for term in self.system.contributions)

    def resolving_step(self, keeps_energy: bool = False) -> float:
        """Return the longest step that resolves impacts [s], as a contribution does."""
        steps = [term.resolving_step(keeps_energy)[0] for term in self.system.contributions]
        return min(steps, default=math.inf)

    @property
    def spans(self) -> list[tuple[float, float]]:
        """Begin and end of the intervals in which all loads are smooth [s]."""
        return self.discontinuities.spans

    @cached_property
    def spectrum(self) -> ModalSpectrum | None:
        """Vibrations of the motion, if they are known."""
        return ModalSpectrum.of(self.system, self.discontinuities, float(self.t[-1]))
