"""Fixtures of tests of kernels."""

import numpy as np
import pytest

from tests.kernels.bench import Bench


@pytest.fixture
def bench():
    return Bench


@pytest.fixture
def rng(request):
    seed = 20240607
    request.node.user_properties.append(("seed", seed))
    return np.random.default_rng(seed)
