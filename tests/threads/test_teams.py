"""The threads that compiled modules share: every part is done once, on a thread of its own."""

import ctypes as ct
import subprocess
import sys
import threading
import time

import pytest

from ancfsparse.dispatch import common_module

PART = ct.CFUNCTYPE(None, ct.c_void_p, ct.c_ssize_t)


@pytest.fixture(scope="module")
def run():
    """Return the C function that does parts, called without the lock of the interpreter."""
    pointer = ct.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ct.c_void_p, (ct.py_object, ct.c_char_p)
    address = pointer(common_module("threads").run, b"ancfsparse.compiled.threads.run")
    return ct.CFUNCTYPE(None, ct.c_ssize_t, PART, ct.c_void_p)(address)


@pytest.mark.parametrize("n_parts", [2, 3, 17, 256])
def test_each_part_is_done_once_on_its_own_thread(run, n_parts):
    done = []
    for _ in range(20):
        done.clear()
        run(n_parts, PART(lambda _, part: done.append((part, threading.get_native_id()))), None)
        assert sorted(part for part, _ in done) == list(range(n_parts))
        assert len({thread for _, thread in done}) == n_parts
        assert dict(done)[0] == threading.get_native_id()


def test_a_call_returns_after_its_slowest_part(run):
    ended = []

    def work(_, part):
        time.sleep(0.05 * part)  # longer than threads look before they sleep
        ended.append(part)

    for _ in range(3):
        ended.clear()
        run(3, PART(work), None)
        assert ended == [0, 1, 2]


def test_threads_are_kept_between_calls(run):
    def threads():
        seen = set()
        run(5, PART(lambda _, part: seen.add(threading.get_native_id())), None)
        return seen

    assert threads() == threads()


def test_calls_at_the_same_time_have_threads_of_their_own(run):
    """Two calls whose parts wait for each other would never end on one set of threads."""
    meeting = threading.Barrier(6, timeout=20)
    work = PART(lambda _, part: meeting.wait())
    callers = [threading.Thread(target=run, args=(3, work, None)) for _ in range(2)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert not meeting.broken


def test_a_part_may_have_parts(run):
    done = []
    inner = PART(lambda _, part: done.append(part))
    run(2, PART(lambda _, part: run(2, inner, None)), None)
    assert sorted(done) == [0, 0, 1, 1]


def test_modules_need_no_library_of_threads():
    """Wheels run where no OpenMP is installed: only scikit-sparse loads one."""
    script = """
import sys
sys.modules["sksparse"] = None
from ancfsparse import simulate
from ancfsparse.problems import chain
run = simulate(chain(12_000, "rough").scene, 1e-3, 5e-4, threads=2)
assert run.stats.threads == 2
with open("/proc/self/maps") as maps:
    print("gomp" in maps.read())
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout == "False\n", done.stderr
