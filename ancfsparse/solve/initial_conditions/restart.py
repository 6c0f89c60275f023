"""How a run goes on from where another one ended."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeGuard

import numpy as np

from ancfsparse.checks import check_finite
from ancfsparse.errors import InputError
from ancfsparse.integrators.interface.integrator import Integrator
from ancfsparse.messages import format_value
from ancfsparse.scene.storage.digest import difference
from ancfsparse.system import System
from ancfsparse.system.coordinates.state import State

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import Loop
    from ancfsparse.nonlinear.loop_protocols import NonlinearLoop

# Share of the largest amplitude by which loads may differ from those before: rounding.
LOAD_TOLERANCE = 1e-9


def check_start(start: object, name: str = "start") -> State | None:
    """Return the state that an argument of this name gives, None for the reference shape.

    Raises
    ------
    InputError
        If it is invalid.
    """
    if start is None:
        return start
    if isinstance(start, State):
        check_finite(f"the time of {name}", start.t, "s")
        return start
    state = getattr(start, "state", None)  # of an equilibrium or an assembly
    if isinstance(state, State):
        return state
    raise InputError(
        f"{name} must be a state such as run.last, or an equilibrium that solve_static has "
        f"returned, got {format_value(start)}"
    )


def save_state(
    system: System,
    integrator: Integrator,
    march: Loop,
    iteration: NonlinearLoop | None,
    t: float,
    dt: float,
) -> State:
    """Return the state that a march has come to, and what its next steps depend on."""
    q, v, a, lam = march.state
    memory = dict(march.memory)
    b = memory.pop("b0", None)
    memory["run"] = {"integrator": repr(integrator), "dt": dt}
    memory["scene"] = system.description
    memory["contributions"] = system.assembly.memory
    if iteration is not None:
        memory["contraction"] = iteration.rate
        memory["measured"] = iteration.measured
    return system.state(t, q, v, a, lam, b=b, memory=memory)


def continues_run(
    state: State | None, system: System, integrator: Integrator, dt: float
) -> TypeGuard[State]:
    """Whether a run with these steps goes on from a state without a new beginning.

    It does if the scene, the integrator and the step are those of the run that ended there.
    """
    if state is None or state.memory.get("run") != {"integrator": repr(integrator), "dt": dt}:
        return False
    if not state.layout.numbers_like(system.layout):
        return False
    if difference(state.memory["scene"], system.description) is not None:
        return False
    # A load that is a function of time may be another function by now.
    now = system.loads.amplitudes(np.array([system.t0]))[0]
    before = np.asarray(state.memory["amplitudes0"])[: len(now)]
    return bool(np.all(np.abs(now - before) <= LOAD_TOLERANCE * np.max(np.abs(now), initial=0.0)))


def restore_contributions(state: State | None, system: System) -> bool:
    """Give contributions what they kept up to a state of the same scene; whether that is any."""
    if state is None or not len(state.memory.get("contributions", ())):
        return False
    if difference(state.memory["scene"], system.scene.digest()) is not None:
        return False
    system.recall(np.asarray(state.memory["contributions"], dtype=float))
    return True


def restore_state(
    state: State, system: System, march: Loop, iteration: NonlinearLoop | None = None
) -> None:
    """Let a march go on with what the run before remembered."""
    memory = dict(state.memory)
    if state.b is not None:
        memory["b0"] = state.b
    march.recall(memory)
    restore_contributions(state, system)
    if iteration is not None:
        iteration.rate = memory["contraction"]
        iteration.measured = memory.get("measured", 0.0)  # older files have none
