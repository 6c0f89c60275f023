"""Energies that a contact has exchanged since the start of a run, among its history variables."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector

# The last history variables of each contact: work of turning obstacles, losses to friction and to
# the damping of impacts.  They are sums over all steps, those of divided ones, too.
N_LOSSES = 3


def select_losses(history: Vector, end: int) -> Vector:
    """Return the energies of a contact whose history variables end there, (k, 3) [J].

    They are not known, NaN, in states without history variables (k, 0).
    """
    if not history.shape[1]:
        return np.full((len(history), N_LOSSES), np.nan)
    return history[:, end - N_LOSSES : end]
