"""Effects that models neglect: their sums, and the largest set that is negligible."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

# Converged elements differ by how bending depends on stretch, so no selection avoids this effect.
FLOOR = "stretch"
# Effects that every element neglects in a motion without time integration.
METHOD_EFFECTS = frozenset({"inertia", "start", "nonlinearity", "modes"})
SOURCE_NAMES = {
    "mesh": "mesh",
    "time": "steps",
    "mesh and steps": "mesh and the steps",
    "solver": "solver",
    "shear": "neglected shear",
    "torsion": "neglected torsion",
    "rotary inertia": "neglected rotary inertia",
    "bending": "neglected bending",
    "inertia": "neglected inertia",
    "start": "vibrations of the start, which start='equilibrium' avoids",
    "nonlinearity": "nonlinear forces",
    "flexibility": "flexibility of rigid rods",
    "modes": "modes left out",
}
"""Names of the sources of errors in sentences."""
# Shorter steps and finer meshes for the rest take less work than richer elements.
NEGLIGIBLE_FRACTION = 0.5  # of the tolerance, up to which modelling errors are accepted
# With 1e-3, the response of a whipped string was beyond its tolerance: small changes grow in it.
LINEAR_FRACTION = 0.01  # of a displacement, a size or a property: changes with linear effects


class Effects(tuple[Mapping[str, float], ...]):
    """Modelling errors by effect, for every quantity [its unit]."""

    def __add__(self, other: Any) -> Effects:
        """Return the sums by effect."""
        pairs = zip(self, other, strict=True)
        return Effects(
            {name: a.get(name, 0.0) + b.get(name, 0.0) for name in {**a, **b}} for a, b in pairs
        )

    def only(self, names: Collection[str]) -> Effects:
        """Return some of the effects."""
        return Effects({k: value for k, value in each.items() if k in names} for each in self)

    @property
    def floors(self) -> tuple[float, ...]:
        """Differences between converged elements."""
        return tuple(each.get(FLOOR, 0.0) for each in self)

    def excess(self, tolerances: Sequence[float]) -> float:
        """Return the largest ratio of a sum of effects to its tolerance."""
        pairs = zip(self, tolerances, strict=True)
        return max(sum(each.values()) / tolerance for each, tolerance in pairs)

    def is_negligible(self, tolerances: Sequence[float]) -> bool:
        """Return True if all sums are negligible."""
        return self.excess(tolerances) < NEGLIGIBLE_FRACTION


def largest_negligible_set(
    effects: Mapping[str, Effects], tolerances: Sequence[float]
) -> tuple[list[str], Effects]:
    """Return the beams whose effects together are negligible, and their sum.

    From the effects by beam, the smallest first.
    """
    names: list[str] = []
    total = Effects({} for _ in tolerances)
    for name in sorted(effects, key=lambda name: effects[name].excess(tolerances)):
        more = total + effects[name]
        if not more.is_negligible(tolerances):
            break
        names.append(name)
        total = more
    return names, total
