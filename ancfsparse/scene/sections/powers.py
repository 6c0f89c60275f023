"""Powers of lengths by products, which are rounded alike in all units that differ by powers of two.

The function `pow` of the C library is not: of sections in other units it may return another last
digit, after which the runs of a chaotic motion differ.
"""

from __future__ import annotations

import math


def power(x: float, n: int) -> float:
    """Return x^n for n > 0."""
    return math.prod([x] * n)
