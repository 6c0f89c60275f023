"""Runs whose errors have no trend are ended early, others go on."""

import pytest

from ancfsparse.solve.error_models.stagnation import MAX_STAGNANT_RUNS, StagnationCheck


def runs(errors):
    """Return the number of runs until their errors are refused, None if they are not."""
    check = StagnationCheck(1e-9)
    for k, error in enumerate(errors, 1):
        if check.add(error) is not None:
            return k
    return None


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0])
def test_errors_that_fall_with_the_steps_go_on(order):
    assert runs(3.0 ** (-order * k) for k in range(30)) is None


def test_a_run_that_is_better_by_chance_does_not_end_those_that_converge():
    errors = [2.0**-k for k in range(12)]
    errors[3] *= 0.3
    assert runs(errors) is None


def test_errors_without_a_trend_are_refused():
    # Of a chaotic motion, by steps divided by 2, 5, 15, 27, 81, 243, 729, 1313, 3939.
    errors = 2.8e-3, 4.9e-3, 2.8e-4, 4.0e-4, 3.0e-4, 2.6e-3, 1.5e-4, 7.8e-3, 9.4e-4
    assert runs(errors) == 7
    assert runs([1.0] * 20) == 1 + MAX_STAGNANT_RUNS
