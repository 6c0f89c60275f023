"""Programs with and without a pickler for functions."""

import sys


def leave_out_cloudpickle(monkeypatch):
    """Let functions be pickled as in programs that do not use a cluster."""
    for name in [each for each in sys.modules if each.split(".")[-1] == "cloudpickle"]:
        monkeypatch.delitem(sys.modules, name)
