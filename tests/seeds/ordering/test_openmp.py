"""How the threads of CHOLMOD's libraries wait: OpenMP is told while it is loaded, and only then."""

import os
import subprocess
import sys

import pytest

pytest.importorskip("sksparse.cholmod")

SCRIPT = """
import os
import ancfsparse.seeds.ordering.cholmod
print(dict(os.environ))
"""


def loaded(**settings):
    """Return the variables left behind, and what OpenMP says of its settings."""
    names = ("GOMP_SPINCOUNT", "OMP_WAIT_POLICY")
    environment = {k: v for k, v in os.environ.items() if k not in names}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env=environment | {"OMP_DISPLAY_ENV": "VERBOSE"} | settings,
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stdout, done.stderr


def test_threads_that_wait_soon_sleep_and_the_environment_is_left_alone():
    left, told = loaded()
    assert "GOMP_SPINCOUNT = '1000'" in told
    assert "GOMP_SPINCOUNT" not in left


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        ({"GOMP_SPINCOUNT": "7"}, "GOMP_SPINCOUNT = '7'"),
        ({"OMP_WAIT_POLICY": "active"}, "OMP_WAIT_POLICY = 'ACTIVE'"),
    ],
)
def test_who_has_settled_it_is_left_alone(settings, line):
    left, told = loaded(**settings)
    assert line in told
    assert "'1000'" not in told
    assert next(iter(settings)) in left
