"""How threads wait for work, and where threads are unavailable.

GCC's OpenMP lets them look for it for milliseconds before they sleep, in which neither other
programs nor other threads run: on a machine that is busy, two threads are ten times slower than
one.  Some ten microseconds are enough on one that is not.  It reads its settings once, when it is
loaded.

A fork copies one thread.  GCC's OpenMP goes on counting on the others that the parent had, and the
child waits for them for ever, so a forked process works with one thread.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager

SETTING, LOOKS = "GOMP_SPINCOUNT", "1000"
CHOICES = frozenset({SETTING, "OMP_WAIT_POLICY"})
"""Variables by which a person decides."""

_forked = False


def _note_fork() -> None:
    global _forked
    _forked = True


if hasattr(os, "register_at_fork"):  # nothing forks on Windows
    os.register_at_fork(after_in_child=_note_fork)


def is_forked() -> bool:
    """Whether this process is a fork of one that had loaded this module."""
    return _forked


@contextmanager
def short_spin_waits() -> Iterator[None]:
    """Let what is loaded now wait briefly, unless a person has decided; leave nothing behind."""
    if CHOICES & os.environ.keys():
        yield
        return
    os.environ[SETTING] = LOOKS
    try:
        yield
    finally:
        del os.environ[SETTING]
