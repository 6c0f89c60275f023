"""Select the number of threads, and divide the work of a run among them."""

from __future__ import annotations

from typing import Protocol

from ancfsparse.checks import check_count
from ancfsparse.errors import InputError
from ancfsparse.system import System
from ancfsparse.threads import is_forked

MAX_THREADS = 256  # as in abi/parallel.h
# Waking a thread takes some ten microseconds, several times in each iteration: chains and nets of
# 20 000 free coordinates gain a factor of 1.3 to 1.5 by a second thread, those of 10 000 none.
MIN_COORDINATES = 16_000  # free coordinates from which several threads are used


class Threaded(Protocol):
    """A compiled object whose passes over vectors can be divided."""

    def set_threads(self, threads: int) -> None:
        """Set the number of threads."""


def check_threads(threads: object) -> int:
    """Return the number of threads after checking it.

    Raises
    ------
    InputError
        If it is not a whole number from 1 to 256.
    """
    n = check_count("threads", threads)
    if n > MAX_THREADS:
        raise InputError(
            f"threads must be at most {MAX_THREADS}, got {n}: more than the machine has are slower"
        )
    return n


def usable_threads(system: System, threads: int, smallest: int = MIN_COORDINATES) -> int:
    """Return the number of threads for a system: all or one; one in a forked process."""
    return threads if system.n_free >= smallest and not is_forked() else 1


def divide_among_threads(system: System, threads: int, *loops: Threaded) -> None:
    """Divide the parts of a solver among threads.

    Parameters
    ----------
    system : System
        Its contributions are divided.
    threads : int
        From `usable_threads`.
    *loops : compiled objects
        Time loop, inverse and nonlinear loop, for their passes over vectors.
    """
    if threads == 1:
        return
    divided = [term.divide(system.n_free, system.n_all, threads) for term in system.contributions]
    if any(divided):
        system.assembly.set_threads(threads)
    for loop in loops:
        loop.set_threads(threads)
