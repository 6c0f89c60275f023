"""Index arrays of sparse matrices by columns."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.integer[Any]]
Triangle = tuple[NDArray[np.int64], NDArray[np.int32]]
"""Starts of the columns and rows of the entries, of an upper or a lower triangle."""
