"""Selection of states of a trajectory."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.results.solutions.trajectory import Trajectory
from ancfsparse.system.coordinates.state import StateHistory


def select_states(run: Trajectory, rows: slice | NDArray[Any], **changes: Any) -> Trajectory:
    """Return a trajectory with some of the saved states of another one.

    With other arrays of the selected states, such as ``q`` and ``v``, and other fields in
    `changes`.
    """
    arrays = {name: np.asarray(getattr(run, name))[rows] for name in StateHistory._fields}
    return replace(run, **{**arrays, **changes})
