"""Refuse to test compiled modules that are older than their sources; select and sort tests."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[1]
# Before NumPy is loaded: BLAS threads of several test processes wait for one another.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def pytest_sessionstart():
    if Path(sys.prefix) == ROOT / ".venv":
        command = [ROOT / "tools/setup.sh", "check"]
        check = subprocess.run(command, capture_output=True, text=True)
        if check.returncode:
            pytest.exit(check.stderr.strip(), returncode=pytest.ExitCode.USAGE_ERROR)


def pytest_addoption(parser):
    parser.addoption("--one-case", action="store_true", help="run each test with its first case")


def pytest_collection_modifyitems(config, items):
    """Begin with files of slow tests, so that all processes end together."""
    if config.getoption("--one-case"):
        first = {}
        for item in items:
            first.setdefault(item.nodeid.partition("[")[0], item)
        kept = set(first.values())
        config.hook.pytest_deselected(items=[item for item in items if item not in kept])
        items[:] = first.values()
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.fixture
def rng(request):
    """Return a generator that makes the same numbers in every run."""
    seed = 20240607
    request.node.user_properties.append(("seed", seed))
    return np.random.default_rng(seed)
