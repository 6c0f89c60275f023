"""Continue a run from the last state of another one."""

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

LOAD_TOLERANCE = 1e-9  # change of the loads over the largest amplitude: rounding


def check_start(start: object, name: str = "start") -> State | None:
    """Return the state that an argument `start` stands for, None for the reference shape.

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
    time_loop: Loop,
    iteration: NonlinearLoop | None,
    t: float,
    dt: float,
) -> State:
    """Return the present state of a time loop, with the memory that its next steps need."""
    q, v, a, lam = time_loop.state
    memory = dict(time_loop.memory)
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
    """Return whether a run with these steps can continue from a state.

    Scene, integrator and step must be those of the run that ended there.
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
    """Restore the internal variables of contributions; return whether the state has any."""
    if state is None or not len(state.memory.get("contributions", ())):
        return False
    if difference(state.memory["scene"], system.scene.digest()) is not None:
        return False
    system.restore_memory(np.asarray(state.memory["contributions"], dtype=float))
    return True


def restore_state(
    state: State, system: System, time_loop: Loop, iteration: NonlinearLoop | None = None
) -> None:
    """Restore the memory of a time loop from a state."""
    memory = dict(state.memory)
    if state.b is not None:
        memory["b0"] = state.b
    time_loop.recall(memory)
    restore_contributions(state, system)
    if iteration is not None:
        iteration.rate = memory["contraction"]
        iteration.measured = memory.get("measured", 0.0)  # older files have none
