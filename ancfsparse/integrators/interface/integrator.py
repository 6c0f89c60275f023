"""Properties that every integrator declares, so that other packages do not depend on its class."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray


class Integrator:
    """Method of time integration.

    Attributes
    ----------
    loop : str
        Compiled module of its time loop.
    keeps_energy : bool
        Whether it conserves the energy for any step.
    matrices : int
        Number of matrices of a step in memory at the same time.
    """

    loop: ClassVar[str]
    keeps_energy: ClassVar[bool] = False
    matrices: ClassVar[int] = 1

    @property
    def order(self) -> int:
        """Order of accuracy."""
        return 2

    @property
    def stages(self) -> NDArray[np.float64]:
        """Times of load evaluation after the start of a step, in steps."""
        return np.ones(1)

    def phase_error(self, z: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the relative error of phase or amplitude of vibrations of z radians per step.

        By default that of the trapezoidal rule, which advances a vibration by 2 atan(z / 2); those
        of Newmark's family are close to it.
        """
        z = np.maximum(np.asarray(z, dtype=np.float64), np.finfo(float).tiny)
        return np.asarray(1.0 - 2.0 * np.arctan(0.5 * z) / z)
