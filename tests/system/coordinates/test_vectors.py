"""Operations on long vectors in C, compiled with one to eight lanes, against NumPy."""

import ctypes as ct
import os
import subprocess
from sysconfig import get_paths

import numpy as np
import pytest

from ancfsparse.instruction_sets import cpu_flags, supported_sets
from tests.headers import HEADERS

SOURCE = """
#include <math.h>
#include "vectors.h"
double largest(const double *x, ptrdiff_t n) { return vec_largest(x, n); }
"""
LANES = {
    1: ("baseline", "-DANCF_LANES=1"),
    2: ("baseline", "-DANCF_LANES=2"),
    4: ("x86_64_v3", "-march=x86-64-v3"),
    8: ("x86_64_v4", "-march=x86-64-v4"),
}


@pytest.fixture(scope="module", params=LANES)
def largest(request, tmp_path_factory):
    instructions, flag = LANES[request.param]
    if instructions != "baseline" and instructions not in supported_sets(cpu_flags()):
        pytest.skip(f"this machine has no {instructions}")
    folder = tmp_path_factory.mktemp("vectors")
    (folder / "vectors.c").write_text(SOURCE)
    rooms = [*{HEADERS[name].parent for name in ("vectors.h", "simd.h")}, get_paths()["include"]]
    compiler = os.environ.get("CC", "cc").split()
    options = ["-O2", "-shared", "-fPIC", "-pthread", *(f"-I{each}" for each in rooms), flag]
    subprocess.run(
        [*compiler, *options, "vectors.c", "-o", "vectors.so"], cwd=folder, check=True, timeout=60
    )
    function = ct.CDLL(str(folder / "vectors.so")).largest
    function.restype, function.argtypes = ct.c_double, [ct.c_void_p, ct.c_ssize_t]
    return lambda x: function(x.ctypes.data, x.size)


@pytest.mark.parametrize("n", [0, 1, 2, 7, 8, 9, 40])
def test_largest_magnitude_at_each_place(largest, n):
    x = np.random.default_rng(n).uniform(-1.0, 1.0, n)
    assert largest(x) == np.abs(x).max(initial=0.0)
    for place in range(n):
        for value in (-3.0, 1e300, -np.inf):
            y = x.copy()
            y[place] = value
            assert largest(y) == abs(value)
        y[place] = np.nan
        assert np.isnan(largest(y))


def test_largest_of_zeros_and_tiny_numbers(largest):
    assert largest(np.array([-0.0, 0.0, -5e-324])) == 5e-324
