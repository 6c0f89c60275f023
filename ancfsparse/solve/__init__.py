"""Solution procedures: each takes a scene and returns a trajectory, an equilibrium or modes.

Stages of a motion (`simulate`), in order; an equilibrium or modes need the first three only:

1. preparation         scene -> solver, factorization, threads, estimated memory
2. initial_conditions  scene, state -> consistent positions, velocities, accelerations, multipliers
3. linearization       system, state -> matrices M, C, K, constraint gradients; rigid-body modes
4. stepping            system, integrator, solver -> compiled time loop, recorder
5. recovery            failed step -> another attempt; steps across singular configurations
6. error_models        system, differences of runs -> spectrum, predicted errors, numbers of steps
7. error_control       accuracy -> candidates, their runs, Richardson estimate, the best solution
8. motion              arguments -> run with a fixed step or to an accuracy -> `Trajectory`

Procedures without time stepping:

statics                scene -> residual, Newton, load stepping -> `Equilibrium`
equilibrium_paths      statics along loads or time -> `LoadPath`, quasi-static `Trajectory`
vibration              matrices about a state -> `Modes`, `ComplexModes`, `Buckling`

A folder imports only from those above it in this list and from statics and its own lower rooms.
"""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.solve.equilibrium_paths.load_path import load_path
    from ancfsparse.solve.equilibrium_paths.quasi_static import quasi_static
    from ancfsparse.solve.motion.resume import resume
    from ancfsparse.solve.motion.simulate import simulate
    from ancfsparse.solve.motion.simulation import Simulation
    from ancfsparse.solve.statics.assemble import assemble
    from ancfsparse.solve.statics.static_equilibrium import solve_static
    from ancfsparse.solve.stepping.stable_step import stable_step
    from ancfsparse.solve.vibration.buckling import buckling
    from ancfsparse.solve.vibration.complex_modes import complex_modes
    from ancfsparse.solve.vibration.modal_response import modal_response
    from ancfsparse.solve.vibration.modes import modes

__all__ = [
    "Simulation",
    "assemble",
    "buckling",
    "complex_modes",
    "load_path",
    "modal_response",
    "modes",
    "quasi_static",
    "resume",
    "simulate",
    "solve_static",
    "stable_step",
]

__getattr__ = on_demand(
    __name__,
    {
        "equilibrium_paths.load_path": "load_path",
        "equilibrium_paths.quasi_static": "quasi_static",
        "motion.resume": "resume",
        "motion.simulate": "simulate",
        "motion.simulation": "Simulation",
        "statics.assemble": "assemble",
        "statics.static_equilibrium": "solve_static",
        "stepping.stable_step": "stable_step",
        "vibration.buckling": "buckling",
        "vibration.complex_modes": "complex_modes",
        "vibration.modal_response": "modal_response",
        "vibration.modes": "modes",
    },
)
