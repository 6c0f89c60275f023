"""The table of integrators by name, for commands, studies and messages."""

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
class Entry:
    """An integrator by name.

    Attributes
    ----------
    make : callable
        Its class.
    damping : str or None
        The parameter that sets its numerical damping.
    fixed : tuple
        Other arguments that the name implies.
    """

    make: Callable[..., Implicit | Explicit]
    damping: str | None = None
    fixed: tuple[Any, ...] = ()


BY_NAME = {
    "newmark": Entry(Newmark, "alpha"),
    "hht": Entry(HHT, "alpha"),
    "generalized-alpha": Entry(GeneralizedAlpha, "rho_inf"),
    "energy-momentum": Entry(EnergyMomentum),
    "central-difference": Entry(CentralDifference),
    "rkn4": Entry(RungeKuttaNystrom, None, (4,)),
    "rkn8": Entry(RungeKuttaNystrom, None, (8,)),
    "dormand-prince": Entry(DormandPrince),
}
"""Names as the command line takes them."""

EXPLICIT = tuple(
    name for name, entry in BY_NAME.items() if isinstance(entry.make(*entry.fixed), Explicit)
)
"""Those that solve no equations."""


def integrator_of(name: str, damping: float | None = None) -> Implicit | Explicit:
    """Return the integrator behind a name.

    Parameters
    ----------
    name : str
        Key of `BY_NAME`.
    damping : float, optional
        Its numerical damping [-]; the default of its class where none is given.
    """
    entry = BY_NAME[name]
    if entry.damping is None or damping is None:
        return entry.make(*entry.fixed)
    return entry.make(*entry.fixed, **{entry.damping: damping})


def _example(entry: Entry) -> str:
    inside = entry.damping or ("order" if entry.fixed else "")
    return f"{entry.make.__name__}({inside})"


EXAMPLES = tuple(dict.fromkeys(_example(entry) for entry in BY_NAME.values()))
"""Constructor call of each, for messages."""
EXPLICIT_EXAMPLES = tuple(dict.fromkeys(_example(BY_NAME[name]) for name in EXPLICIT))
"""The explicit ones alone."""
