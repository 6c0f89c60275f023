"""The energy-momentum method: the midpoint rule with a discrete gradient of the strain energy.

    q1 - q0 = dt (v0 + v1) / 2,
    M (v1 - v0) / dt + DU(q0, q1) + Q_d(q_m, v_m) + phi_q(q_m)^T lam = f,   phi(q1) = 0,

with m for the middle of the step.  DU . (q1 - q0) = U(q1) - U(q0), so the strain energy a step
gains is the work of the elastic forces in it; constraints are quadratic, so phi_q(q_m) (q1 - q0) =
phi(q1) - phi(q0) = 0 and they do no work.  See Simo and Tarnow (1992), Gonzalez (1996, 2000).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

from ancfsparse.integrators.implicit.newmark_family import Implicit


@dataclass(frozen=True)
class EnergyMomentum(Implicit):
    """Implicit and of second order; keeps energy and momentum whatever the step and the stiffness.

    What a step changes in the energy is the work of loads and of damping, and what the iteration
    leaves.  A free body keeps its momentum and its angular momentum as well.  Nothing is damped:
    waves that a step does not resolve stay, so stresses, accelerations and multipliers of stiff
    bodies oscillate where those of `GeneralizedAlpha` do not.  Accelerations and multipliers are
    means over the step before the time they are given at.
    """

    loop = "conserving"
    keeps_energy = True
    matrices = 2  # the sum, and what is added to it
    residual_kernels: ClassVar[Mapping[str, int]] = MappingProxyType(
        {"residual": 1, "discrete_gradient": 1, "force": -1}
    )
    matrix_kernels: ClassVar[Mapping[str, int]] = MappingProxyType({"tangent": 2, "material": 3})

    alpha_m = 0.0
    alpha_f = 0.0

    @property
    def scale(self) -> float:
        """Change of a coordinate per unit of mean acceleration, over dt^2."""
        return 0.5

    @property
    def damping_scale(self) -> float:
        """Change of a velocity per unit of mean acceleration, over dt."""
        return 1.0
