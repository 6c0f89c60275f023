"""Properties that every integrator declares, so that no other package depends on its class."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray


class Integrator:
    """A method that advances a system by steps.

    Attributes
    ----------
    loop : str
        Compiled module of its time loop.
    keeps_energy : bool
        Whether it keeps the energy whatever the step is.
    matrices : int
        Matrices of a step that it keeps at the same time.
    """

    loop: ClassVar[str]
    keeps_energy: ClassVar[bool] = False
    matrices: ClassVar[int] = 1

    @property
    def order(self) -> int:
        """Power of the step in the error."""
        return 2

    @property
    def stages(self) -> NDArray[np.float64]:
        """Times in a step at which loads are evaluated, over the step, after its start."""
        return np.ones(1)
