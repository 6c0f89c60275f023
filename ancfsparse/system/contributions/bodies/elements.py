"""The elements of a scene by bodies, as arrays for their kernels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Indices, Integers, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.kernels.element_kind import REFERENCE, ElementKind
from ancfsparse.kernels.layout import Layout, pack
from ancfsparse.scene import Beam, ElasticBody
from ancfsparse.system import assembly, loads
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import Compiled, Contribution, matrix_unknowns
from ancfsparse.system.coordinates.discretization import Discretization
from ancfsparse.system.coordinates.numbering import reference_coordinates

if TYPE_CHECKING:
    from ancfsparse.system.loads.time_dependent_eigenstrain import TimeDependentEigenstrain


class CompiledElements(Compiled, Protocol):
    """The elements of all bodies (_elements.pyx)."""

    @property
    def groups(self) -> list[dict[str, Any]]:
        """Arrays and kernels of each body."""

    def divide(self, run_start: Any, runs: Any) -> None:
        """Assign the elements to threads."""


class ElementContribution(Contribution):
    """The elements of a system."""

    def __init__(self, system: Discretization) -> None:
        self._system = system
        self._compiled: CompiledElements
        # By body: its time-dependent eigenstrain, and the index of its first amplitude.
        self._changing: dict[int, tuple[TimeDependentEigenstrain, int]] = {}
        for k, body in enumerate(system.scene.beams):
            if isinstance(body, Beam) and body.strains_change:
                self._changing[k] = _make_eigenstrain(system, body), system.loads.n_amplitudes
                system.loads.sources.append(self._changing[k][0])

    def cliques(self) -> list[Indices]:
        """Return the coordinates of every element, a table for each body."""
        return [self._unknowns(body) for body in self._system.scene.beams]

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled elements."""
        groups = []
        for k, body in enumerate(self._system.scene.beams):
            kind = self._system.kind_of(body)
            slots = pattern.slots(self._unknowns(body))
            base = base_parameters(body, kind, body.stiffnesses())
            layout = pack(kind, self._system.elements(body), slots, base)
            del slots
            groups.append(
                {
                    "layout": layout.compress(),
                    "kernels": kind.kernels,
                    "tuned": self._tuned(k, layout, kind.lanes),
                    **_damping_arrays(body, kind, self._system.elements(body)),
                }
            )
        self._compiled = compiled_module("elements").Elements(groups, self._system.n_all)
        return self._compiled

    @property
    def layouts(self) -> list[Layout]:
        """Arrays of the elements of each body."""
        return [group["layout"] for group in self._compiled.groups]

    def divide(self, n_free: int, n_all: int, threads: int) -> bool:
        """Assign the elements to threads, unless too many share coordinates."""
        runs = assembly.partition_elements(self.layouts, n_free, n_all, threads)
        if runs is not None:
            self._compiled.divide(*runs)
        return runs is not None

    def _tuned(
        self, k: int, layout: Layout, lanes: int
    ) -> tuple[Integers, Integers, Vector] | None:
        """Return indices of changed parameters and of their amplitudes, and constant values."""
        if k not in self._changing:
            return None
        strain, first = self._changing[k]
        place, column = strain.places(layout.set_of, lanes)
        return place, column + np.int32(first), layout.parameters.ravel()[place]

    def _unknowns(self, body: ElasticBody) -> Indices:
        return matrix_unknowns(self._system.elements(body), self._system.n_free)


def of(system: Discretization) -> list[ElementContribution]:
    """Return the elements of a system."""
    return [ElementContribution(system)]


def _make_eigenstrain(system: Discretization, body: Beam) -> TimeDependentEigenstrain:
    """Return the parameter changes by the time-dependent eigenstrain of a beam."""
    kind, common = system.kind_of(body), body.stiffnesses()
    base = base_parameters(body, kind, common)
    return loads.TimeDependentEigenstrain(body, kind, reference_coordinates(body)[body.ends], base)


def _damping_arrays(body: ElasticBody, kind: ElementKind, places: Integers) -> dict[str, Any]:
    """Return the damping arrays of a body, none without damping."""
    flags = {"strains_damped": body.strains_damped, "masses_damped": body.masses_damped}
    if not any(flags.values()):
        return flags
    layout = pack(kind, places, places, base_parameters(body, kind, body.viscosities()))
    return flags | {"damping_set_of": layout.set_of, "damping_parameters": layout.parameters}


def base_parameters(body: ElasticBody, kind: ElementKind, common: Mapping[str, float]) -> Vector:
    """Return the base parameters of every element, (n_e, n_base), at constant eigenstrain.

    Each element has its length and, if curved, its stress-free coordinates.
    """
    base = np.empty((body.n_elements, len(kind.parameters)))
    for k, name in enumerate(kind.parameters):
        if not name.startswith(REFERENCE):
            base[:, k] = body.lengths if name == "length" else common[name]
    if kind.is_curved:
        ends = body.free_of_stress(reference_coordinates(body)[body.ends])
        base[:, reference_parameters(kind)] = ends.reshape(body.n_elements, -1)
    return base


def reference_parameters(kind: ElementKind) -> NDArray[np.intp]:
    """Return the indices of the base parameters that are stress-free coordinates."""
    return np.flatnonzero([name.startswith(REFERENCE) for name in kind.parameters])
