"""Predict how much a motion amplifies small disturbances, from its stiffness at some times.

Where the stiffness has a negative eigenvalue, as in a compressed beam, disturbances grow with its
root.  Two runs show that only if their errors differ in the shape that grows: a motion in a plane
that is about to leave it seems accurate.
"""

from __future__ import annotations

import numpy as np

from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.error_models.modal_spectrum import (
    MAX_COORDINATES,
    dense_symmetric,
    tangent_stiffness,
)
from ancfsparse.solve.linearization.matrices import mass_matrix
from ancfsparse.solve.stepping.sampled_states import SampledStates
from ancfsparse.system import System

# Intervals between the sampled states: 20 select the same motions to within one in a hundred.
N_INTERVALS = 8


def growth_exponent(
    system: System, discontinuities: LoadDiscontinuities, states: SampledStates
) -> float:
    """Return the logarithm of the amplification of small disturbances in a run.

    The integral of the largest growth rate over time, by the mean over some states.

    Parameters
    ----------
    system : System
        The moving system.
    discontinuities : LoadDiscontinuities
        Contains sampled amplitudes of the loads.
    states : SampledStates
        States of the run.

    Returns
    -------
    float
        Zero if there are rigid bodies, or too many coordinates.
    """
    import scipy.linalg

    if not 0 < system.n_free <= MAX_COORDINATES or any(system.constraints.mass):
        return 0.0
    times, last = discontinuities.times[:-1], len(states.t) - 1
    mass, rates = dense_symmetric(mass_matrix(system)), []
    for k in np.unique(np.linspace(0, last, N_INTERVALS + 1).round().astype(int)):
        load = discontinuities.amplitudes[np.searchsorted(times, states.t[k])]
        lam = np.asarray(states.lam[k])
        stiffness, basis = tangent_stiffness(system, states.q[k], lam, load)
        pair = basis.T @ stiffness @ basis, basis.T @ mass @ basis
        smallest = scipy.linalg.eigh(*pair, eigvals_only=True, subset_by_index=[0, 0])[0]
        rates.append(np.sqrt(max(-smallest, 0.0)))
    return float(np.mean(rates) * (states.t[-1] - states.t[0]))
