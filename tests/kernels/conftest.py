"""Fixtures of tests of kernels."""

import pytest

from tests.kernels.bench import Bench


@pytest.fixture
def bench():
    return Bench
