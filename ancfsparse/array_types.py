"""Types of arrays, for annotations."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]  # of any shape: coordinates, times or forces, or rows of them
Complex = NDArray[np.complex128]
Integers = NDArray[np.int32]  # positions of entries in vectors, as compiled code takes them
Indices = NDArray[np.integer[Any]]
