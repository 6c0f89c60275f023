"""The benchmark measures what it says, on every kernel."""

from ancfsparse.kernels.catalog import element_kind
from benchmarks.common.kernel_timing import time_kernel


def test_every_kernel_can_be_timed():
    kind = element_kind("thin", 3)
    for kernel in kind.kernels:
        assert time_kernel(kind, kernel, n_elements=9, seconds=1e-4, rounds=2) > 0
