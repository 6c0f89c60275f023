"""How many threads a run may use, and what of it is divided among them."""

from __future__ import annotations

from typing import Protocol

from ancfsparse.checks import check_count
from ancfsparse.errors import InputError
from ancfsparse.openmp import is_forked
from ancfsparse.system import System

# As in abi/parallel.h.
MOST = 256
# Free coordinates from which a second thread gains: waking it takes some ten microseconds, several
# times in each iteration.  Chains and nets of 20 000 gain 1.3 to 1.5, of 10 000 nothing.
SMALLEST = 16_000


class Threaded(Protocol):
    """What takes passes over vectors."""

    def set_threads(self, threads: int) -> None:
        """Set the number of threads."""


def check_threads(threads: object) -> int:
    """Return the number of threads; refuse an invalid one.

    Raises
    ------
    InputError
        If it is not a whole number from 1 to 256.
    """
    wanted = check_count("threads", threads)
    if wanted > MOST:
        raise InputError(
            f"threads must be at most {MOST}, got {wanted}: more than the machine has are slower"
        )
    return wanted


def usable(system: System, threads: int, smallest: int = SMALLEST) -> int:
    """Return how many threads pay for a system: all of them or one; one in a forked process."""
    return threads if system.n_free >= smallest and not is_forked() else 1


def divide(system: System, threads: int, *loops: Threaded) -> None:
    """Let the parts of a solver use threads.

    Parameters
    ----------
    system : System
        What adds to its equations is dealt out.
    threads : int
        As `usable` returns it.
    *loops : compiled objects
        March, inverse and nonlinear loop, for their passes over vectors.
    """
    if threads == 1:
        return
    dealt = [each.divide(system.n_free, system.n_all, threads) for each in system.contributions]
    if any(dealt):
        system.assembly.set_threads(threads)
    for loop in loops:
        loop.set_threads(threads)
