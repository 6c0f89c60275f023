"""What a person chooses: Newton, modified Newton, or quasi-Newton with an update and a memory."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from functools import partial

from ancfsparse.checks import check_choice, check_count, check_flag
from ancfsparse.errors import InputError

UPDATES = ("broyden", "davidon", "dfp", "bfgs")
SEEDS = ("tangent", "finite-difference")
SEED_FRAMES = ("auto", "fixed", "rotating")


class Solver:
    """Properties that every method declares, so that no other package depends on its class."""

    @property
    def is_dense(self) -> bool:
        """Whether it keeps a dense inverse, which is never renewed."""
        return False

    @property
    def by_differences(self) -> bool:
        """Whether its first inverse comes from finite differences."""
        return False

    @property
    def pairs(self) -> int:
        """Secant pairs that it keeps on a sparse seed."""
        return 0

    @property
    def frame(self) -> str:
        """Which frame its seeds have: "auto", "fixed" or "rotating"."""
        return "fixed"


@dataclass(frozen=True)
class Newton(Solver):
    """Full Newton: the generated tangent is factored again in every iteration.

    Parameters
    ----------
    max_iterations : int, optional
        Corrections allowed in a step before the recovery ladder is entered.
    """

    max_iterations: int = 25

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_count("max_iterations", self.max_iterations)


@dataclass(frozen=True)
class ModifiedNewton(Solver):
    """Newton with one factor for many steps, renewed when the counts show that it pays.

    Parameters
    ----------
    max_iterations : int, optional
        Corrections allowed in a step before the recovery ladder is entered.
    seed_frame : {"auto", "fixed", "rotating"}, optional
        Whether the factor stays as it was taken or is turned with the nodes of the body, or is
        tried both ways and used in the way that costs fewer operations per step.
    """

    max_iterations: int = 25
    seed_frame: str = "auto"

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_count("max_iterations", self.max_iterations)
        check_choice("seed_frame", self.seed_frame, SEED_FRAMES)

    @property
    def frame(self) -> str:
        """Which frame its seeds have."""
        return self.seed_frame


@dataclass(frozen=True)
class QuasiNewton(Solver):
    """Quasi-Newton: an inverse that is updated from the corrections (equations 12 to 16).

    Parameters
    ----------
    update : {"broyden", "davidon", "dfp", "bfgs"}
        Broyden's first method (equation 13), Davidon's symmetric rank-one (14), Davidon, Fletcher,
        Powell (15, "DPF" in the paper), Broyden, Fletcher, Goldfarb, Shanno (16).
    memory : "full" or int
        ``"full"``: a dense inverse that is never forgotten, the paper's form, for up to a few
        thousand coordinates.  A number: that many secant pairs on a sparse seed.
    carry : bool, optional
        With a number: whether pairs outlive their step.  They save iterations and seeds, and on
        long chains and nets cost more than they save.
    seed : {"tangent", "finite-difference"}, optional
        The first inverse: from the generated tangent, or from finite differences of the residual
        as in the paper (``memory="full"`` only).
    max_iterations : int, optional
        Corrections allowed in a step before the recovery ladder is entered.
    seed_frame : {"auto", "fixed", "rotating"}, optional
        Whether seed and pairs stay as they were taken or are turned with the nodes of the body.
        ``"auto"`` tries both and takes what costs fewer operations per step; a dense inverse,
        which learns the rotation by itself, it leaves fixed.
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
        """Whether it keeps a dense inverse, which is never renewed."""
        return self.memory == "full"

    @property
    def by_differences(self) -> bool:
        """Whether its first inverse comes from finite differences."""
        return self.seed == "finite-difference"

    @property
    def pairs(self) -> int:
        """Secant pairs that it keeps on a sparse seed."""
        return 0 if self.is_dense else int(self.memory)

    @property
    def frame(self) -> str:
        """Which frame its seeds have: a dense inverse learns the rotation by itself."""
        return "fixed" if self.is_dense and self.seed_frame == "auto" else self.seed_frame


Method = Newton | ModifiedNewton | QuasiNewton


BY_NAME: dict[str, Callable[..., Method]] = {
    "newton": Newton,
    "modified-newton": ModifiedNewton,
    **{update: partial(QuasiNewton, update) for update in UPDATES},
}
"""Names for the command line, which adds "auto"; parameters follow."""
