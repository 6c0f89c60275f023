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
# The same with contact between beams, whose pairs cost more: heaps of 4600 and 6600 gain a factor
# of 1.2 to 1.45, hairs of 6100, few of which touch, lose up to 6 %, those of 2500 up to 10 %.
MIN_COORDINATES_OF_TOUCHING_BEAMS = 4_000


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


def usable_threads(system: System, threads: int) -> int:
    """Return the number of threads for a system: all or one; one in a forked process."""
    touches = any(term.is_between_beams for term in system.contributions)
    smallest = MIN_COORDINATES_OF_TOUCHING_BEAMS if touches else MIN_COORDINATES
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
