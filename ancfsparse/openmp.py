"""Waiting times of OpenMP threads, and detection of forked processes.

Idle threads of GCC's OpenMP spin for milliseconds before they sleep, and block the processors for
other programs and threads: on a busy machine two threads are ten times slower than one.  About ten
microseconds suffice on an idle machine.  The setting is read once, when OpenMP is loaded.

A fork copies one thread, but GCC's OpenMP in the child still waits for the other threads of the
parent, without end.  A forked process therefore uses one thread.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager

VARIABLE = "GOMP_SPINCOUNT"
SPIN_COUNT = "1000"  # spins, about ten microseconds
USER_VARIABLES = frozenset({VARIABLE, "OMP_WAIT_POLICY"})
"""Environment variables by which a user sets waiting times."""

_is_fork = False


def _note_fork() -> None:
    global _is_fork
    _is_fork = True


if hasattr(os, "register_at_fork"):  # nothing forks on Windows
    os.register_at_fork(after_in_child=_note_fork)


def is_forked() -> bool:
    """Return True in a fork of a process that had loaded this module."""
    return _is_fork


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
