"""Threads that compiled modules share (`teams.h`), and detection of forked processes.

A fork copies one thread: the threads that wait for work exist in the parent alone.  A forked
process therefore uses one thread.
"""

import os

_is_fork = False


def _note_fork() -> None:
    global _is_fork
    _is_fork = True


if hasattr(os, "register_at_fork"):  # not on Windows
    os.register_at_fork(after_in_child=_note_fork)


def is_forked() -> bool:
    """Return True in a fork of a process that had loaded this module."""
    return _is_fork
