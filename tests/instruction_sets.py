"""Which instruction sets tests can compare here."""

import pytest

from ancfsparse.dispatch import available_instruction_sets, built_instruction_sets


def require(*names):
    """Skip a test of sets that this machine cannot run, or that `make setup` left out."""
    for name in names:
        if name not in built_instruction_sets():
            pytest.skip(f"not compiled for {name}; `make test` does so")
        if name not in available_instruction_sets():
            pytest.skip(f"this machine has no {name}")
