"""The one table of integrators and solvers that studies choose from, by their names in tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from ancfsparse.integrators import (
    HHT,
    CentralDifference,
    DormandPrince,
    EnergyMomentum,
    Explicit,
    GeneralizedAlpha,
    Implicit,
    Newmark,
    RungeKuttaNystrom,
)
from ancfsparse.nonlinear import Method, ModifiedNewton, Newton, QuasiNewton
from benchmarks.common.paper import QUASI_NEWTON

IMPLICIT: dict[str, Implicit] = {
    "Newmark(0)": Newmark(0.0),
    "Newmark(0.05)": Newmark(0.05),
    "HHT(0.05)": HHT(0.05),
    "HHT(0.3)": HHT(0.3),
    "GeneralizedAlpha(0.9)": GeneralizedAlpha(0.9),
    "GeneralizedAlpha(0.8)": GeneralizedAlpha(0.8),
    "GeneralizedAlpha(0.5)": GeneralizedAlpha(0.5),
    "EnergyMomentum": EnergyMomentum(),
}

EXPLICIT: dict[str, Explicit] = {
    "CentralDifference": CentralDifference(),
    "RungeKuttaNystrom(4)": RungeKuttaNystrom(4),
    "RungeKuttaNystrom(8)": RungeKuttaNystrom(8),
    "DormandPrince": DormandPrince(),
}

INTEGRATORS: dict[str, Implicit | Explicit] = {**IMPLICIT, **EXPLICIT}

PAIRS = 10
SOLVERS: dict[str, Method | str] = {
    "auto": "auto",
    "Newton": Newton(),
    "modified Newton": ModifiedNewton(),
    **{name: QuasiNewton(update) for name, update in QUASI_NEWTON.items()},
    **{f"{update}, full": QuasiNewton(update, "full") for update in QUASI_NEWTON.values()},
    **{f"{u}, {PAIRS} pairs": QuasiNewton(u, PAIRS) for u in QUASI_NEWTON.values()},
}
"""Quasi-Newton by the paper's names with the default memory, by updates with the memory named."""

Entry = TypeVar("Entry")


def chosen(table: Mapping[str, Entry], *names: str) -> dict[str, Entry]:
    """Return the named entries of a table, in that order."""
    return {name: table[name] for name in names}
