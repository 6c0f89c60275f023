"""From a numbered scene to the arrays that the compiled assembly works on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled
from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.kernels.layout import pack
from ancfsparse.scene import Body
from ancfsparse.system.numbering import Places
from ancfsparse.system.pattern import Pattern, build

if TYPE_CHECKING:
    from ancfsparse.system.system import System

Vector = NDArray[np.float64]


def pattern_of(system: System) -> Pattern:
    """Return the lower triangle of the saddle point matrix of a numbered scene."""
    cliques = [_unknowns(system, system.elements(beam)) for beam in system.scene.beams]
    cliques += [
        _unknowns(system, frame.reshape(1, -1).copy()) for frame in system.loads.moment_place
    ]
    return build(system.n_free + system.n_multipliers, [*cliques, _term_unknowns(system)])


def assembly_of(system: System) -> Any:
    """Build the compiled assembly of a system that has its pattern."""
    groups = []
    for beam, kind in zip(system.scene.beams, system.kinds, strict=True):
        slots = system.pattern.slots(_unknowns(system, system.elements(beam)))
        base = base_parameters(beam, kind, beam.stiffnesses())
        layout = pack(kind, system.elements(beam), slots, base)
        del slots
        groups.append(
            {
                "layout": layout.compressed(),
                "kernels": kind.kernels,
                **_damping(beam, kind, system.elements(beam)),
            }
        )
    constraints, changing, moments = _terms(system)
    return compiled("assembly").Assembly(
        system.n_free,
        system.n_all,
        system.pattern.n_values,
        system.loads.n_amplitudes,
        compiled("elements").Elements(groups),
        compiled("moments").Moments(moments),
        constraints,
        changing,
    )


def _terms(system: System) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """Constraints, changing loads and moments as arrays for the assembly."""
    c, loads = system.constraints, system.loads
    # Pairs by rows: (row, row), (i, row), (i, i), (j, row), (j, i), (j, j).
    pairs = system.pattern.slots(_term_unknowns(system))
    ends = system.n_free + np.arange(system.n_multipliers)
    constraints = {
        "row": np.array(c.row, dtype=np.int32),
        "i": np.array(c.i, dtype=np.int32),
        "j": np.array(c.j, dtype=np.int32),
        "slot_i": pairs[:, 1].copy(),
        "slot_j": pairs[:, 3].copy(),
        "slot_ij": pairs[:, 4].copy(),
        "coefficient": np.array(c.coefficient, dtype=float),
        "about": np.array(c.about, dtype=float),
        "offset": np.array(c.offset, dtype=float),
        "diagonal": system.pattern.slots(ends[:, None])[:, 0].copy(),
    }
    changing = {
        "place": np.array(loads.place, dtype=np.int32),
        "column": np.array(loads.column, dtype=np.int32),
        "weight": np.array(loads.weight, dtype=float),
    }
    places = np.array(loads.moment_place, dtype=np.int32).reshape(-1, 3 * system.dim)
    moments = {
        "place": places,
        "slot": system.pattern.slots(_unknowns(system, places.copy())),
        "column": np.array(loads.moment_column, dtype=np.int32).ravel(),
    }
    return constraints, changing, moments


def _term_unknowns(system: System) -> Places:
    """Per constraint term its equation and the one or two coordinates in it, (n_terms, 3)."""
    c = system.constraints
    row, i, j = (np.array(x, dtype=np.int32) for x in (c.row, c.i, c.j))
    return np.stack([system.n_free + row, _unknowns(system, i), _unknowns(system, j)], axis=1)


def _unknowns(system: System, places: Places) -> Places:
    """Turn places, in place, into numbers of unknowns in the matrix; -1 for the fixed ones."""
    places[places >= system.n_free] = -1
    return places


def _damping(body: Body, kind: ElementKind, places: Places) -> dict[str, Any]:
    """Return what the assembly needs to damp a body, as few arrays as it can."""
    flags = {"strains_damped": body.strains_damped, "masses_damped": body.masses_damped}
    if not any(flags.values()):
        return flags
    layout = pack(kind, places, places, base_parameters(body, kind, body.viscosities()))
    return flags | {"damping_set_of": layout.set_of, "damping_parameters": layout.parameters}


def base_parameters(body: Body, kind: ElementKind, common: Mapping[str, float]) -> Vector:
    """Return the base parameters of every element, (n_e, n_base), all but the length in common."""
    lengths = body.lengths
    base = np.empty((body.n_elements, len(kind.parameters)))
    for k, name in enumerate(kind.parameters):
        base[:, k] = lengths if name == "length" else common[name]
    return base
