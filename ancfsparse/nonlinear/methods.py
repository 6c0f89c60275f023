"""Methods for the equations of a step: Newton, modified Newton and quasi-Newton."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from functools import partial

from ancfsparse.checks import check_choice, check_count, check_flag
from ancfsparse.errors import InputError

UPDATES = ("broyden", "davidon", "dfp", "bfgs")
SEEDS = ("tangent", "finite-difference")
SEED_FRAMES = ("auto", "fixed", "rotating")


class NonlinearMethod:
    """Properties that every method declares, so that other packages do not depend on its class."""

    @property
    def is_dense(self) -> bool:
        """True if it stores a dense inverse, which is never renewed."""
        return False

    @property
    def by_differences(self) -> bool:
        """True if its first inverse is that of a matrix of finite differences."""
        return False

    @property
    def pairs(self) -> int:
        """Number of secant pairs that it stores on a sparse seed."""
        return 0

    @property
    def frame(self) -> str:
        """Frame of its seeds: "auto", "fixed" or "rotating"."""
        return "fixed"


@dataclass(frozen=True)
class Newton(NonlinearMethod):
    """Newton's method: the generated tangent is factored in every iteration.

    Parameters
    ----------
    max_iterations : int, optional
        Maximum number of corrections in a step before the recovery sequence.
    """

    max_iterations: int = 25

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_count("max_iterations", self.max_iterations)


@dataclass(frozen=True)
class ModifiedNewton(NonlinearMethod):
    """Modified Newton: one factorization for many steps, renewed if counts show a saving.

    Parameters
    ----------
    max_iterations : int, optional
        Maximum number of corrections in a step before the recovery sequence.
    seed_frame : {"auto", "fixed", "rotating"}, optional
        Whether the factor is fixed or rotates with the nodes of the body; ``"auto"`` tries both and
        uses the one with fewer operations per step.
    """

    max_iterations: int = 25
    seed_frame: str = "auto"

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_count("max_iterations", self.max_iterations)
        check_choice("seed_frame", self.seed_frame, SEED_FRAMES)

    @property
    def frame(self) -> str:
        """Frame of its seeds."""
        return self.seed_frame


@dataclass(frozen=True)
class QuasiNewton(NonlinearMethod):
    """Quasi-Newton method: an inverse updated by secant pairs (equations 12 to 16).

    Parameters
    ----------
    update : {"broyden", "davidon", "dfp", "bfgs"}
        Broyden's first method (equation 13), Davidon's symmetric rank-one (14), Davidon, Fletcher,
        Powell (15, "DPF" in the paper), Broyden, Fletcher, Goldfarb, Shanno (16).
    memory : "full" or int
        ``"full"``: a dense inverse that is never renewed, as in the paper, for up to a few thousand
        coordinates.  A number: this many secant pairs on a sparse seed.
    carry : bool, optional
        With a number: whether pairs are carried over to the next step.  They save iterations and
        seeds; on long chains and nets they cost more than they save.
    seed : {"tangent", "finite-difference"}, optional
        The first inverse: from the generated tangent, or from finite differences of the residual
        as in the paper (``memory="full"`` only).
    max_iterations : int, optional
        Maximum number of corrections in a step before the recovery sequence.
    seed_frame : {"auto", "fixed", "rotating"}, optional
        Whether seed and pairs are fixed or rotate with the nodes of the body; ``"auto"`` tries both
        and uses the one with fewer operations per step.  A dense inverse, which follows rotations
        by its updates, is fixed.
    """

    update: str = "davidon"
    memory: str | int = "full"
    _: KW_ONLY
    carry: bool = False
    seed: str = "tangent"
    max_iterations: int = 25
    seed_frame: str = "auto"

    def __post_init__(self) -> None:
        """Check names and numbers."""
        check_choice("seed_frame", self.seed_frame, SEED_FRAMES)
        check_choice("update", self.update, UPDATES)
        check_choice("seed", self.seed, SEEDS)
        check_count("max_iterations", self.max_iterations)
        check_flag("carry", self.carry)
        if isinstance(self.memory, str):
            check_choice("memory", self.memory, ("full",))
        else:
            check_count("memory", self.memory)
            if self.seed != "tangent":
                raise InputError(
                    "a finite-difference seed is a dense matrix: use it with memory='full', or "
                    "leave seed='tangent'"
                )

    @property
    def is_dense(self) -> bool:
        """True if it stores a dense inverse, which is never renewed."""
        return self.memory == "full"

    @property
    def by_differences(self) -> bool:
        """True if its first inverse is that of a matrix of finite differences."""
        return self.seed == "finite-difference"

    @property
    def pairs(self) -> int:
        """Number of secant pairs that it stores on a sparse seed."""
        return 0 if self.is_dense else int(self.memory)

    @property
    def frame(self) -> str:
        """Frame of its seeds: a dense inverse follows rotations by its updates."""
        return "fixed" if self.is_dense and self.seed_frame == "auto" else self.seed_frame


Method = Newton | ModifiedNewton | QuasiNewton


BY_NAME: dict[str, Callable[..., Method]] = {
    "newton": Newton,
    "modified-newton": ModifiedNewton,
    **{update: partial(QuasiNewton, update) for update in UPDATES},
}
"""Names for the command line, which adds "auto"; parameters follow."""
