"""The Python interface of the compiled seeds; types only."""

from __future__ import annotations

from typing import Any, Protocol

from numpy.typing import NDArray

from ancfsparse.array_types import Vector


class CompiledSeed(Protocol):
    """A compiled seed (_blocks.pyx)."""

    @property
    def capsule(self) -> object:
        """Structure "ancf_seed" for the nonlinear loop."""

    def solve(self, r: Vector) -> Vector:
        """Return the solution (n,) for the right-hand side (n,)."""


class Factor(CompiledSeed, Protocol):
    """A seed that can be factored again."""

    @property
    def nbytes(self) -> int:
        """Memory of its arrays [bytes]."""

    def factor(self, values: Vector) -> int:
        """Factor; return 0, or 1 + the first unknown whose pivot has the wrong sign."""

    def columns(self) -> tuple[NDArray[Any], ...]:
        """Arrays of the factor by columns."""


class CompleteFactor(Factor, Protocol):
    """Complete factorization L D L^T (_ldl.pyx)."""

    @property
    def negative_pivots(self) -> int | None:
        """Number of negative pivots; None if one was zero or not a number."""

    @property
    def pivots(self) -> Vector:
        """Pivots (n,), in the order of the unknowns."""

    def round_to_single(self) -> None:
        """Round the factor to single precision, until the next one."""


class PythonSeed(Protocol):
    """A seed written in Python behind the structure of the compiled ones (_callback.pyx)."""

    error: BaseException | None

    @property
    def capsule(self) -> object:
        """Structure "ancf_seed" for the nonlinear loop."""
