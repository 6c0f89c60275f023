"""Messages whose arguments are data: their styles, and that errors survive pickling."""

import pickle

import pytest

import ancfsparse as ancf
from ancfsparse.checks import check_count, check_positive
from ancfsparse.cli.options import option_style
from ancfsparse.errors import (
    InputError,
    LoadError,
    MessageTemplate,
    Parameter,
    StepError,
    python_style,
)


@pytest.mark.parametrize(
    ("parameter", "python", "option"),
    [
        (Parameter("dt"), "dt", "--step"),
        (Parameter("dt", "0.1 s"), "dt = 0.1 s", "--step 0.1 s"),
        (Parameter("accuracy", "0.1", "="), "accuracy=0.1", "--accuracy 0.1"),
        (Parameter("n_elements of beam 1"), "n_elements of beam 1", "--elements of beam 1"),
        (Parameter("threads", "2"), "threads = 2", "threads = 2"),
        (Parameter("max_iterations", is_optional=True), " (max_iterations)", ""),
        (
            Parameter("integrator", "GeneralizedAlpha(0.9)", separator=""),
            "GeneralizedAlpha(0.9)",
            "--integrator generalized-alpha",
        ),
    ],
)
def test_each_style_has_names_of_its_own(parameter, python, option):
    assert (python_style(parameter), option_style(parameter)) == (python, option)


def test_parts_of_a_message_are_written_in_its_style():
    inner = MessageTemplate("a larger {dt}", dt=Parameter("dt"))
    text = "{end} in {n:.2f} steps; try {advice}"
    outer = MessageTemplate(text, end=Parameter("t_end", "1 s"), n=3.0, advice=inner)
    assert str(outer) == "t_end = 1 s in 3.00 steps; try a larger dt"
    assert outer.format(option_style) == "--time 1 s in 3.00 steps; try a larger --step"


def test_a_text_without_values_keeps_its_braces():
    assert str(InputError("the options {'a': 1}")) == "the options {'a': 1}"
    error = InputError("got {given}", given="{dt}")
    assert str(error) == "got {dt}"


def caught(function, *arguments):
    with pytest.raises(InputError) as error:
        function(*arguments)
    return error.value


@pytest.mark.parametrize(
    ("function", "arguments", "name"),
    [
        (check_positive, ("dt", -1.0, "s"), "dt"),
        (check_count, ("n_elements", 0), "n_elements"),
        (ancf.Newmark, (2.0,), None),
    ],
)
def test_an_error_knows_its_argument(function, arguments, name):
    assert caught(function, *arguments).parameter == name


def test_errors_survive_pickling():
    error = caught(check_positive, "dt", -1.0, "s")
    copy = pickle.loads(pickle.dumps(error))
    assert (str(copy), copy.parameter) == (str(error), "dt")
    reason = MessageTemplate(
        "no end in 25 iterations{parameter}",
        parameter=Parameter("max_iterations", is_optional=True),
    )
    failure = pickle.loads(pickle.dumps(StepError(reason, 1.0, 2, 0.5, 3.0, "beam 0")))
    assert failure.reason == "no end in 25 iterations (max_iterations)"
    assert "no end in 25 iterations." in failure.message(option_style)
    late = pickle.loads(pickle.dumps(LoadError("the load failed", 1.0)))
    assert (str(late), late.time) == ("the load failed", 1.0)
