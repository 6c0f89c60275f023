"""The energy-momentum method: the midpoint rule with a discrete gradient of the strain energy.

    q1 - q0 = dt (v0 + v1) / 2,
    M (v1 - v0) / dt + DU(q0, q1) + Q_d(q_m, v_m) + phi_q(q_m)^T lam = f,   phi(q1) = 0,

with m for the midpoint of the step.  DU . (q1 - q0) = U(q1) - U(q0), so the change of the strain
energy in a step is the work of the elastic forces; constraints are quadratic, so phi_q(q_m) (q1 -
q0) = phi(q1) - phi(q0) = 0 and they do no work.  See Simo and Tarnow (1992), Gonzalez (1996, 2000).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

from ancfsparse.integrators.implicit.newmark_family import Implicit


@dataclass(frozen=True)
class EnergyMomentum(Implicit):
    """Implicit second-order method that conserves energy and momentum for any step and stiffness.

    The energy changes in a step by the work of loads and damping, and by the error of the
    iteration.  Momentum and angular momentum of a free body are conserved as well.  There is no
    numerical damping: vibrations that a step does not resolve persist, so stresses, accelerations
    and multipliers of stiff bodies oscillate, unlike with `GeneralizedAlpha`.  Accelerations and
    multipliers are mean values over the step before their time.
    """

    loop = "conserving"
    keeps_energy = True
    matrices = 2  # the sum and a summand
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
