"""Waiting times of the OpenMP threads that CHOLMOD's libraries bring with them.

Idle threads of GCC's OpenMP spin for milliseconds before they sleep, and block the processors for
other programs and threads: on a busy machine two threads are ten times slower than one.  About ten
microseconds suffice on an idle machine.  The setting is read once, when OpenMP is loaded.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager

VARIABLE = "GOMP_SPINCOUNT"
SPIN_COUNT = "1000"  # spins, about ten microseconds
USER_VARIABLES = frozenset({VARIABLE, "OMP_WAIT_POLICY"})
"""Environment variables by which a user sets waiting times."""


@contextmanager
def short_spin_waits() -> Iterator[None]:
    """Load OpenMP with short spin times, unless the user has set them; restore the environment."""
    if USER_VARIABLES & os.environ.keys():
        yield
        return
    os.environ[VARIABLE] = SPIN_COUNT
    try:
        yield
    finally:
        del os.environ[VARIABLE]
