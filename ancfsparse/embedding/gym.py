"""Environments of Gymnasium: a controller acts on the inputs of a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse import embedding
from ancfsparse.checks import check_count, check_positive
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene import Input, Scene
from ancfsparse.solve import Simulation

if TYPE_CHECKING:
    from ancfsparse.embedding.environment import Environment


def make(
    scene: Scene,
    actions: Mapping[Input, tuple[ArrayLike, ArrayLike]],
    observations: Sequence[Callable[[Simulation], ArrayLike]],
    reward: Callable[[Simulation], float],
    dt: float,
    substeps: int = 1,
    *,
    t_end: float | None = None,
    ends: Callable[[Simulation], bool] | None = None,
    begin: Callable[[Simulation, np.random.Generator], object] | None = None,
    bounds: tuple[ArrayLike, ArrayLike] | None = None,
    **options: Any,
) -> Environment:
    """Return a Gymnasium environment in which actions set the inputs of a scene.

    Parameters
    ----------
    scene : Scene
        The scene.
    actions : dict of Input to (low, high)
        Inputs that an action sets, in order, with their least and greatest values [unit of their
        uses]; numbers, or arrays (size,); a component whose limits are
        equal keeps that value and is no part of an action.
    observations : sequence of callable
        Functions of the `Simulation` that return numbers or arrays, joined to one observation.
    reward : callable
        Function of the simulation that returns the reward of the state after a step.
    dt : float
        Time step [s].
    substeps : int, optional
        Time steps in a step of the environment.
    t_end : float, optional
        Time after which an episode is truncated [s].
    ends : callable, optional
        Function of the simulation that returns True in a terminal state.
    begin : callable, optional
        Function of the simulation and a NumPy generator that is called at each reset, for example
        to set inputs and to take steps.
    bounds : (low, high), optional
        Limits of the observations, by default infinite.
    **options
        Further arguments of `Simulation`.

    Returns
    -------
    Environment
        The environment.  Several run side by side in
        ``gymnasium.vector.AsyncVectorEnv([build] * 4)``, where `build` calls this function.

    Raises
    ------
    InputError
        If an argument is invalid, or Gymnasium is not installed.
    """
    if not isinstance(actions, Mapping) or not actions:
        raise InputError(
            "actions must name inputs with their limits, such as {force: (-10, 10)}, got "
            f"{format_value(actions)}"
        )
    for name, functions in (
        ("observations", observations),
        ("reward", [reward]),
        ("ends", [ends] if ends is not None else []),
        ("begin", [begin] if begin is not None else []),
    ):
        if not isinstance(functions, Sequence) or not all(map(callable, functions)):
            raise InputError(f"{name} must be functions, got {format_value(functions)}")
    if not observations:
        raise InputError("observations must have a function, such as lambda sim: sim.t")
    if t_end is not None:
        check_positive("t_end", t_end, "s")
    simulation = Simulation(scene, dt, **options)
    for each in actions:
        simulation.value(each)  # refuses inputs that the scene does not use
    n = check_count("substeps", substeps)
    return embedding.environment.Environment(
        simulation, actions, observations, reward, n, t_end, ends, begin, bounds
    )
