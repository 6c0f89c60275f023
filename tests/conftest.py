"""What tests of several rooms share."""

import sys

import pytest


@pytest.fixture
def no_cloudpickle(monkeypatch):
    """Leave functions to pickle, as in programs that do not use a cluster."""
    for name in [each for each in sys.modules if each.split(".")[-1] == "cloudpickle"]:
        monkeypatch.delitem(sys.modules, name)
