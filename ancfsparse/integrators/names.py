"""Table of integrators by name, for commands, benchmarks and messages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ancfsparse.integrators.explicit.explicit_methods import (
    CentralDifference,
    DormandPrince,
    Explicit,
    RungeKuttaNystrom,
)
from ancfsparse.integrators.implicit.energy_momentum import EnergyMomentum
from ancfsparse.integrators.implicit.newmark_family import HHT, GeneralizedAlpha, Implicit, Newmark


@dataclass(frozen=True)
class NamedIntegrator:
    """Integrator with a name.

    Attributes
    ----------
    make : callable
        Its class.
    damping : str or None
        Name of the parameter for its numerical damping.
    fixed : tuple
        Arguments implied by the name.
    """

    make: Callable[..., Implicit | Explicit]
    damping: str | None = None
    fixed: tuple[Any, ...] = ()


BY_NAME = {
    "newmark": NamedIntegrator(Newmark, "alpha"),
    "hht": NamedIntegrator(HHT, "alpha"),
    "generalized-alpha": NamedIntegrator(GeneralizedAlpha, "rho_inf"),
    "energy-momentum": NamedIntegrator(EnergyMomentum),
    "central-difference": NamedIntegrator(CentralDifference),
    "rkn4": NamedIntegrator(RungeKuttaNystrom, None, (4,)),
    "rkn8": NamedIntegrator(RungeKuttaNystrom, None, (8,)),
    "dormand-prince": NamedIntegrator(DormandPrince),
}
"""Integrators by their names in commands."""

EXPLICIT = tuple(
    name for name, entry in BY_NAME.items() if isinstance(entry.make(*entry.fixed), Explicit)
)
"""Names of explicit integrators."""


def integrator_of(name: str, damping: float | None = None) -> Implicit | Explicit:
    """Return the integrator with a name.

    Parameters
    ----------
    name : str
        Key of `BY_NAME`.
    damping : float, optional
        Its numerical damping [-]; by default that of its class.
    """
    entry = BY_NAME[name]
    if entry.damping is None or damping is None:
        return entry.make(*entry.fixed)
    return entry.make(*entry.fixed, **{entry.damping: damping})


def _example(entry: NamedIntegrator) -> str:
    inside = entry.damping or ("order" if entry.fixed else "")
    return f"{entry.make.__name__}({inside})"


EXAMPLES = tuple(dict.fromkeys(_example(entry) for entry in BY_NAME.values()))
"""Constructor calls, for messages."""
EXPLICIT_EXAMPLES = tuple(dict.fromkeys(_example(BY_NAME[name]) for name in EXPLICIT))
"""Constructor calls of explicit integrators."""
