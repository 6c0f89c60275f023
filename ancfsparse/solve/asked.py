"""Motions for a quantity and its error: their mesh and step are chosen by a plan."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from ancfsparse.errors import InputError
from ancfsparse.messages import shown
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene


@runtime_checkable
class Plannable(Protocol):
    """What knows how to plan for itself and others: a quantity."""

    def plan(self, scene: Scene, t_end: float, quantity: Any, error: Any, **fixed: Any) -> Any:
        """Return a plan, whose ``run`` marches the scene."""


def run_as_asked(
    scene: Scene,
    t_end: float,
    quantity: Any,
    error: Any,
    fixed: dict[str, Any],
    options: dict[str, Any],
    refused: dict[str, Any],
) -> Trajectory:
    """Plan a motion, and march it.

    Parameters
    ----------
    scene, t_end, quantity, error
        As `simulate` takes them.
    fixed : dict
        Step, integrator and start, which a plan keeps.
    options : dict
        Other arguments of the run.
    refused : dict
        Arguments that a plan sets by itself, those that differ from their defaults.

    Raises
    ------
    InputError
        If one of both is missing or no quantity, or an argument is a plan's own.
    """
    if quantity is None or error is None:
        given, missing = ("error", "quantity") if quantity is None else ("quantity", "error")
        raise InputError(
            f"simulate was given {given}=... but no {missing}: give both, as in "
            "quantity=ancf.position(rod.end), error=1e-3"
        )
    for name, value in refused.items():
        raise InputError(
            f"simulate was given an error, so a plan sets {name} by itself: leave "
            f"{name}={shown(value)} out, or leave quantity and error out"
        )
    first = quantity[0] if isinstance(quantity, list | tuple) and quantity else quantity
    if not isinstance(first, Plannable):
        raise InputError(
            "quantity must be what ancf.position(rod.end) and its like return, or a list of them, "
            f"got {shown(quantity)}"
        )
    run: Trajectory = first.plan(scene, t_end, quantity, error, **fixed).run(**options)
    return run
