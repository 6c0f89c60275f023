"""The checks say what is wrong, where, how much and what to try."""

import pickle
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from ancfsparse.checks import (
    check_choice,
    check_count,
    check_finite,
    check_flag,
    check_positive,
    check_reals,
    check_vector,
)
from ancfsparse.errors import (
    AncfError,
    EquilibriumError,
    InputError,
    SingularSceneError,
    StepError,
)
from ancfsparse.messages import format_value


def test_every_error_is_one_of_ours_and_of_the_builtin_kind():
    assert issubclass(InputError, AncfError)
    assert issubclass(InputError, ValueError)
    assert issubclass(SingularSceneError, InputError)
    assert issubclass(StepError, RuntimeError)
    assert issubclass(EquilibriumError, RuntimeError)


def test_step_failure_reads_as_sentences():
    error = StepError(
        "no convergence in 25 iterations",
        0.206,
        412,
        5e-4,
        3.1e-4,
        "beam 0, node 7, slope y",
        "run",
        "Try another day.",
    )
    assert str(error) == (
        "step 412 (t = 0.206 s, dt = 0.0005 s) failed: no convergence in 25 iterations. "
        "The largest residual is 0.00031 at beam 0, node 7, slope y. "
        "Try another day. "
        "The states up to here are in the attribute `trajectory` of this error."
    )
    assert (error.time, error.step, error.dt, error.residual) == (0.206, 412, 5e-4, 3.1e-4)
    assert error.trajectory == "run"


def test_failures_survive_the_way_between_processes():
    failure = StepError("reason", 1.0, 2, 0.5, 1e-3, "beam 0", None, "Try less.")
    step = pickle.loads(pickle.dumps(failure))
    assert str(step) == str(failure)
    assert (step.reason, step.step, step.where, step.trajectory) == ("reason", 2, "beam 0", None)
    still = pickle.loads(pickle.dumps(EquilibriumError("no convergence.", 0.25, 7.0, "node 3")))
    assert still.load_fraction == 0.25
    assert "no equilibrium at 25 % of the load: no convergence. The" in str(still)
    assert "residual is 7 at node 3" in str(still)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("broydn", "unknown update 'broydn': did you mean 'broyden'? Valid are 'broyden', 'bfgs'"),
        ("BFGS", "unknown update 'BFGS': did you mean 'bfgs'? Valid are 'broyden', 'bfgs'"),
        ("xyz", "unknown update 'xyz': valid are 'broyden', 'bfgs'"),
        (3, "unknown update 3: valid are 'broyden', 'bfgs'"),
    ],
)
def test_unknown_names_meet_the_nearest_valid_one(name, message):
    with pytest.raises(InputError) as caught:
        check_choice("update", name, ["broyden", "bfgs"])
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (0.0, "dt must be positive, got 0 s"),
        (-1e-3, "dt must be positive, got -0.001 s"),
        (np.nan, "dt must be finite, got nan s"),
        (np.inf, "dt must be finite, got inf s"),
        ("fast", "dt must be a number, got 'fast'"),
        (None, "dt must be a number, got None"),
        (True, "dt must be a number, got True"),
        ([1.0], r"dt must be a number, got \[1.0\]"),
        ([[1, 2], [3]], r"dt must be a number, got \[\[1, 2\], \[3\]\]"),
        (1 + 5j, r"dt must be a number, got \(1\+5j\)"),
        (np.complex128(1), "dt must be a number, got"),
        (10**400, "dt must be a number, got an integer beyond 1.8e308"),
        (-(10**400), "dt must be a number, got an integer beyond 1.8e308"),
        (Decimal("1e400"), "dt must be finite, got inf s"),
        (Decimal("sNaN"), "dt must be a number"),
        (np.longdouble("1e400"), "dt must be finite, got inf s"),
        (np.timedelta64(1, "s"), "dt must be a number"),
        (np.ma.masked, "dt must be a number, got masked"),
        (b"1", "dt must be a number, got b'1'"),
        (np.array("1"), "dt must be a number"),
    ],
)
def test_positive_numbers(value, message):
    with pytest.raises(InputError, match=message):
        check_positive("dt", value, "s")


def test_good_numbers_pass_unchanged():
    assert check_positive("dt", np.float64(0.5), "s") == 0.5
    assert check_finite("x", -3) == -3.0
    assert check_finite("x", Fraction(1, 4)) == 0.25
    assert check_finite("x", Decimal("0.5")) == 0.5
    assert type(check_finite("x", np.array(0.5))) is float
    assert check_count("n", np.int64(4)) == 4
    assert check_choice("x", "a", ["a"]) == "a"


@pytest.mark.parametrize("value", [0, -2, True])
def test_counts_below_the_lowest(value):
    with pytest.raises(InputError, match=f"n must be an integer of at least 1, got {value}"):
        check_count("n", value)


@pytest.mark.parametrize("value", [2.0, "two", None, 1 + 0j, [1], np.array([1, 2]), np.ma.masked])
def test_counts_that_are_no_integers(value):
    with pytest.raises(InputError, match="n must be an integer, got"):
        check_count("n", value)


@pytest.mark.parametrize(
    ("value", "dim", "message"),
    [
        ((0, 0, 1), 2, r"start has 3 components, but the scene is planar: give \(x, y\), or give "
                       r"the gravity of the scene 3 components to make it spatial"),
        ((0, 0), 3, r"start has 2 components, but the scene is spatial: give \(x, y, z\), or give "
                    r"the gravity of the scene 2 components to make it planar"),
        ([[0, 0]], 2, r"start has shape \(1, 2\)"),
        (1.0, 2, r"start has shape \(\)"),
        ((0, np.nan), 2, "start must be finite, but its y component is nan m"),
        ((np.inf, 0), 2, "start must be finite, but its x component is inf m"),
        ("ab", 2, "start must be 2 numbers, got 'ab'"),
        ([[1], [1, 2]], 2, "start must be 2 numbers, got"),
        (["0", "-9.81"], 2, r"start must be 2 numbers, got \['0', '-9.81'\]"),
        ([1 + 5j, 0], 2, r"start must be 2 numbers, got \[\(1\+5j\), 0\]"),
        (np.ma.array([0.0, -9.81], mask=[0, 1]), 2, "start must be 2 numbers, got masked_array"),
        ([True, False], 2, r"start must be 2 numbers, got \[True, False\]"),
        ([10**400, 1], 2, "start must be 2 numbers, got .an integer beyond 1.8e308, 1"),
        ([None, 1], 2, "start must be 2 numbers"),
        ([True, 10**400], 2, "start must be 2 numbers"),
        (np.longdouble(["1e400", "1"]), 2, "its x component is inf m"),
    ],
)  # fmt: skip
def test_vectors(value, dim, message):
    with pytest.raises(InputError, match=message):
        check_vector("start", value, dim, "m")


def test_a_checked_vector_is_a_read_only_copy():
    given = np.array([1.0, 2.0])
    checked = check_vector("start", given, 2)
    given[0] = 5.0
    assert checked[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        checked[0] = 3.0


def test_switches_are_true_or_false():
    assert check_flag("progress", True) is True
    assert check_flag("progress", np.False_) is False
    for value in (1, 0, "no", None, (0.0, 1.0), np.array([True]), lambda t: t):
        with pytest.raises(InputError, match="progress must be True or False, got"):
            check_flag("progress", value)


def test_more_than_can_be_counted():
    assert check_count("n", 10**30) == 10**30
    with pytest.raises(InputError, match=r"n is an integer beyond 1\.8e308, more than can be"):
        check_count("n", 10**400)


def test_arrays_of_fractions_are_numbers_and_masks_that_hide_nothing_do_not_matter():
    np.testing.assert_array_equal(check_reals("x", [Fraction(1, 2), 1], "numbers"), [0.5, 1.0])
    np.testing.assert_array_equal(check_reals("x", np.ma.array([1.0, 2.0]), "numbers"), [1.0, 2.0])


class Rude:
    def __repr__(self):
        raise RuntimeError("no")


@pytest.mark.parametrize(
    "value",
    [np.zeros((50, 50)), "x" * 5000, 10**5000, [10**5000] * 9, Rude()],
    ids=["array", "text", "integer", "integers", "no repr"],
)
def test_what_is_shown_is_one_short_line(value):
    text = format_value(value)
    assert len(text) < 250
    assert "\n" not in text
