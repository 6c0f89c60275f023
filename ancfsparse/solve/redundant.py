"""Which constraints of a scene repeat others, by the rank of their gradients at the start."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import RedundantConstraints
from ancfsparse.system import System

# Share of a gradient that must be independent of the others, or it is redundant.
LEFT = 1e-8
# Share of a linear combination from which a constraint is named as a part of it.
PART = 1e-3
# Largest number of equations for which this is checked: a fraction of a second.
MOST = 300
# Number of constraints that are named.
NAMED = 3


def warn_of_repeats(system: System) -> None:
    """Warn of constraints that repeat others.

    Their forces are not unique; a small regularization distributes them.

    Warns
    -----
    RedundantConstraints
        With the first of them and what they repeat.
    """
    constraints = system.constraints
    if not 0 < len(constraints.offset) <= MOST:
        return
    found = repeats(system)
    if not found:
        return
    labels = constraints.labels
    words = [f"the {labels[row]}, {_because(labels, of)}" for row, of in found[:NAMED]]
    more = f" and {len(found) - NAMED} more" if len(found) > NAMED else ""
    warnings.warn(
        f"{len(found)} of {len(labels)} constraints repeat others at the start: "
        f"{'; '.join(words)}{more}.  The motion is not affected, but their forces are distributed "
        "arbitrarily: leave out a joint that repeats another, or use one with more freedom",
        RedundantConstraints,
        stacklevel=4,
    )


def _because(labels: list[str], others: list[int]) -> str:
    """Name what an equation follows from."""
    if not others:
        return "which holds nothing that can move"
    more = f" and {len(others) - 1} more" if len(others) > 1 else ""
    return f"which follows from the {labels[others[0]]}{more}"


def repeats(system: System) -> list[tuple[int, list[int]]]:
    """Return the equations that repeat others, and those that they are made of, largest part first.

    Equations that keep bodies rigid come first, so that joints are found to repeat them.
    """
    phi_q = system.constraints.jacobian(system.q0)[:, : system.n_free].toarray()
    order = np.argsort(np.array(system.constraints.mass) == 0.0, kind="stable")
    basis: list[NDArray[np.float64]] = []
    taken: list[int] = []
    found = []
    for row in order:
        size = float(np.linalg.norm(phi_q[row]))
        left = phi_q[row] / size if size > 0.0 else phi_q[row]
        for _ in range(2):  # the second time takes away what rounding left
            if basis:
                table = np.array(basis)
                left = left - table.T @ (table @ left)
        rest = float(np.linalg.norm(left))
        if rest > LEFT:
            basis.append(left / rest)
            taken.append(int(row))
            continue
        others = np.array(taken, dtype=int)
        parts = np.linalg.lstsq(phi_q[others].T, phi_q[row], rcond=None)[0] if len(taken) else []
        shares = np.abs(parts) * np.linalg.norm(phi_q[others], axis=1) if len(taken) else []
        largest = np.argsort(-np.asarray(shares), kind="stable")
        found.append((int(row), [int(others[k]) for k in largest if shares[k] > PART * size]))
    return found
