"""How threads wait for work.

GCC's OpenMP lets them look for it for milliseconds before they sleep, in which neither other
programs nor other threads run: on a machine that is busy, two threads are ten times slower than
one.  Some ten microseconds are enough on one that is not.  It reads its settings once, when it is
loaded.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager

SETTING, LOOKS = "GOMP_SPINCOUNT", "1000"
CHOICES = frozenset({SETTING, "OMP_WAIT_POLICY"})
"""Variables by which a person decides."""


@contextmanager
def brief_waits() -> Iterator[None]:
    """Let what is loaded now wait briefly, unless a person has decided; leave nothing behind."""
    if CHOICES & os.environ.keys():
        yield
        return
    os.environ[SETTING] = LOOKS
    try:
        yield
    finally:
        del os.environ[SETTING]
