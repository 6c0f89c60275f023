"""Errors of the library in the terms of the command: its options instead of arguments."""

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
    """A run of the command ended early; the message names the options of the command."""


# What the library calls what the command has options for.
OPTIONS = {
    "t_end": "--time",
    "dt": "--step",
    "n_elements": "--elements",
    "save_every": "--save-every",
    "accuracy": "--accuracy",
    "tolerance": "--tolerance",
}
ADVICE = (
    "Try --integrator generalized-alpha --rho-inf 0.8, which damps what the steps cannot follow, a "
    "smaller --step, or --accuracy 1e-3 with it."
)
ADVICE_ON_ACCURACY = "Try a smaller --accuracy, or --rho-inf 0.8, which damps more."
ADVICE_ON_EXPLICIT = "Try a smaller --step, or --integrator generalized-alpha."


# Integrators that sentences of the library advise.
INTEGRATOR_OPTIONS = {
    "GeneralizedAlpha(0.9)": "--integrator generalized-alpha",
    "GeneralizedAlpha(rho_inf)": "--integrator generalized-alpha",
}


@contextmanager
def in_options() -> Iterator[None]:
    """Show errors of the library with the options of the command."""
    try:
        yield
    except InputError as error:
        raise InputError(error.message(option_style)) from error
    except (StepError, AccuracyError) as error:
        raise RunError(_ended(error)) from error


def option_style(parameter: Parameter) -> str:
    """Show an argument of the library as an option of the command, if there is one.

    Parameters
    ----------
    parameter : Parameter
        Its name may be followed by what it belongs to: ``"n_elements of beam 1"``.
    """
    if parameter.value in INTEGRATOR_OPTIONS:
        return INTEGRATOR_OPTIONS[parameter.value]
    name, *owner = parameter.name.split(" ", 1)
    if name not in OPTIONS:
        return "" if parameter.is_optional else python_style(parameter)
    return " ".join([OPTIONS[name], *owner, *[parameter.value] * bool(parameter.value)])


def _ended(error: StepError | AccuracyError) -> str:
    """Return why a run ended, with advice that the command can follow; it keeps no states."""
    if isinstance(error, InstabilityError):
        error.advice = ADVICE_ON_EXPLICIT
    elif isinstance(error, StepError):
        error.advice = ADVICE_ON_ACCURACY if error.trajectory is None else ADVICE
    error.trajectory = None
    return error.message(option_style)
