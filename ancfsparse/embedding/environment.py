"""The class of the environments of Gymnasium; needs that package."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_finite
from ancfsparse.errors import InputError, StepError
from ancfsparse.messages import format_value
from ancfsparse.scene import Input
from ancfsparse.solve import Simulation

try:
    import gymnasium
except ImportError as missing:
    raise InputError(
        "an environment needs Gymnasium, which is not installed: pip install 'ancfsparse[gym]', or "
        "step a Simulation"
    ) from missing

Observation = Callable[[Simulation], ArrayLike]


class Environment(gymnasium.Env):  # type: ignore[misc]
    """A scene as an environment; see `ancfsparse.gym.make`.

    Attributes
    ----------
    simulation : Simulation
        The motion.
    action_space, observation_space : gymnasium.spaces.Box
        Components of inputs that have a range [unit of their uses], and of all observations.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": []}

    def __init__(
        self,
        simulation: Simulation,
        actions: Mapping[Input, tuple[ArrayLike, ArrayLike]],
        observations: Sequence[Observation],
        reward: Callable[[Simulation], float],
        substeps: int,
        t_end: float | None,
        ends: Callable[[Simulation], bool] | None,
        begin: Callable[[Simulation, np.random.Generator], object] | None,
        bounds: tuple[ArrayLike, ArrayLike] | None,
    ) -> None:
        self.simulation, self._reward, self._ends, self._begin = simulation, reward, ends, begin
        self._actions, self._observations = list(actions), list(observations)
        self._substeps, self._t_end = substeps, t_end
        self._start = simulation.snapshot()
        ranges = [_check_range(each, *its_range) for each, its_range in actions.items()]
        low, high = (np.concatenate(part) for part in zip(*ranges, strict=True))
        self._values, self._is_free = low.copy(), low < high
        self.action_space = gymnasium.spaces.Box(
            low[self._is_free], high[self._is_free], dtype=np.float64
        )
        size = len(self.observe())
        limits = (-np.inf, np.inf) if bounds is None else bounds
        try:
            low, high = (np.array(np.broadcast_to(each, size), float) for each in limits)
        except ValueError:
            raise InputError(
                f"bounds must be two numbers or two arrays ({size},), one for each number that is "
                f"observed, got {format_value(bounds)}"
            ) from None
        self.observation_space = gymnasium.spaces.Box(low, high, dtype=np.float64)

    def observe(self) -> Vector:
        """Return the observations in the present state, (n,)."""
        return np.concatenate([np.ravel(each(self.simulation)) for each in self._observations])

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Vector, dict[str, Any]]:
        """Return to the start."""
        super().reset(seed=seed)
        self.simulation.restore(self._start)
        if self._begin is not None:
            self._begin(self.simulation, self.np_random)
        return self.observe(), {}

    def step(self, action: Vector) -> tuple[Vector, float, bool, bool, dict[str, Any]]:
        """Set the inputs, with ramps over the step, and advance.

        A step that fails truncates the episode, and the information has its message as "error".
        """
        sim = self.simulation
        values = np.asarray(action, float)
        if values.shape != self.action_space.shape or not np.all(np.isfinite(values)):
            raise InputError(
                f"an action must be {self.action_space.shape[0]} finite numbers, got "
                f"{format_value(action)}"
            )
        self._values[self._is_free] = values
        first = 0
        for each in self._actions:
            value = self._values[first : first + each.size]
            sim.set(each, value if each.size > 1 else value[0], over=self._substeps * sim.dt)
            first += each.size
        information: dict[str, Any] = {}
        try:
            sim.step(self._substeps)
        except StepError as error:
            information["error"] = str(error)
        is_late = self._t_end is not None and sim.t > self._t_end - 0.5 * sim.dt
        is_over = self._ends is not None and bool(self._ends(sim))
        truncated = "error" in information or is_late
        return self.observe(), float(self._reward(sim)), is_over, truncated, information


def _check_range(which: Input, low: ArrayLike, high: ArrayLike) -> tuple[Vector, Vector]:
    """Return the limits of an input, (size,) each."""
    name = f"of {which.name}"
    lower, upper = (
        np.array([check_finite(f"the limits {name}", x) for x in np.broadcast_to(each, which.size)])
        for each in (low, high)
    )
    if not np.all(lower <= upper):
        raise InputError(
            f"the lower limit {name} must not exceed the upper one, got {format_value(low)} and "
            f"{format_value(high)}"
        )
    return lower, upper
