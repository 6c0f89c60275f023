"""Error messages with command-line options in place of Python arguments."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from ancfsparse.errors import (
    AccuracyError,
    AncfError,
    InputError,
    InstabilityError,
    Parameter,
    StepError,
    python_style,
)


class RunError(AncfError):
    """A run of the command failed; the message names command-line options."""


OPTIONS = {
    "t_end": "--time",
    "dt": "--step",
    "n_elements": "--elements",
    "save_every": "--save-every",
    "accuracy": "--accuracy",
    "tolerance": "--tolerance",
}
"""Options of the command by arguments in Python."""
ADVICE = (
    "Try --integrator generalized-alpha --rho-inf 0.8, which damps unresolved frequencies, a "
    "smaller --step, or --accuracy 1e-3 with it."
)
ADVICE_ON_ACCURACY = "Try a smaller --accuracy, or --rho-inf 0.8, which damps more."
ADVICE_ON_EXPLICIT = "Try a smaller --step, or --integrator generalized-alpha."


INTEGRATOR_OPTIONS = {
    "GeneralizedAlpha(0.9)": "--integrator generalized-alpha",
    "GeneralizedAlpha(rho_inf)": "--integrator generalized-alpha",
}
"""Options of the integrators suggested in messages."""


@contextmanager
def in_options() -> Iterator[None]:
    """Write error messages with command-line options."""
    try:
        yield
    except InputError as error:
        raise InputError(error.message(option_style)) from error
    except (StepError, AccuracyError) as error:
        raise RunError(_describe_failure(error)) from error


def option_style(parameter: Parameter) -> str:
    """Write an argument as a command-line option, if there is one.

    Parameters
    ----------
    parameter : Parameter
        The argument; its name may be followed by its object: ``"n_elements of beam 1"``.
    """
    if parameter.value in INTEGRATOR_OPTIONS:
        return INTEGRATOR_OPTIONS[parameter.value]
    name, *owner = parameter.name.split(" ", 1)
    if name not in OPTIONS:
        return "" if parameter.is_optional else python_style(parameter)
    return " ".join([OPTIONS[name], *owner, *[parameter.value] * bool(parameter.value)])


def _describe_failure(error: StepError | AccuracyError) -> str:
    """Return the reason of a failure, with advice on command-line options."""
    if isinstance(error, InstabilityError):
        error.advice = ADVICE_ON_EXPLICIT
    elif isinstance(error, StepError):
        error.advice = ADVICE_ON_ACCURACY if error.trajectory is None else ADVICE
    error.trajectory = None
    return error.message(option_style)
