"""The paper's pendulum in PyElastica: a Cosserat rod, explicit in time.

The rod is flexible in shear and stretch; its section is a circle of the pendulum's area, whose
bending stiffness is set to the square's.
"""

from __future__ import annotations

import contextlib
import io
import math
import time
import warnings
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.problems import Problem

Tips = NDArray[np.float64]

# A circle's second moment of area over that of a square of the same area.
CIRCLE_TO_SQUARE = 3.0 / math.pi


def load() -> Any:
    """Return the module.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of its own imports
            return import_module("elastica")
    except ImportError as error:
        raise InputError(
            f"PyElastica cannot be imported ({error}): pip install 'ancfsparse[peers]'"
        ) from None


def run_elastica(
    problem: Problem, elements: int, t_end: float, dt: float, outputs: int
) -> tuple[float, Tips]:
    """Simulate the pendulum with PyElastica's rod and its position Verlet method.

    Returns
    -------
    seconds : float
        Wall time of its time loop [s], without the compilation that a first step sets off.
    tip : (outputs, 2) float
        Tip at equal intervals up to the end [m].
    """
    elastica = load()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its own code
        _march(elastica, problem, elements, [1], dt)
        return _march(elastica, problem, elements, [round(t_end / outputs / dt)] * outputs, dt)


def _march(
    elastica: Any, problem: Problem, elements: int, parts: list[int], dt: float
) -> tuple[float, Tips]:
    """Take the steps of each part and look at the tip after it."""
    simulator, rod = _build(elastica, problem, elements)
    stepper = elastica.PositionVerlet()
    tips = []
    now = np.float64(0.0)
    begin = time.perf_counter()
    with contextlib.redirect_stdout(io.StringIO()):
        for steps in parts:
            now = elastica.integrate(
                stepper, simulator, steps * dt, steps, restart_time=now, progress_bar=False
            )
            tips.append(rod.position_collection[:2, -1].copy())
    return time.perf_counter() - begin, np.array(tips)


def _build(elastica: Any, problem: Problem, elements: int) -> tuple[Any, Any]:
    """Set up the rod, its hinge and its weight."""
    scene, beam = problem
    given, material = beam.parameters(), beam.material
    area = given["mass_per_length"] / material.density

    class Simulator(elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing):  # type: ignore[misc]
        pass

    rod = elastica.CosseratRod.straight_rod(
        elements,
        np.zeros(3),
        np.array([1.0, 0.0, 0.0]),
        np.array([0.0, 1.0, 0.0]),
        beam.length,
        math.sqrt(area / math.pi),
        material.density,
        youngs_modulus=material.youngs_modulus,
        shear_modulus=0.5 * material.youngs_modulus / (1.0 + material.poisson_ratio),
    )
    rod.bend_matrix[:] /= CIRCLE_TO_SQUARE
    simulator = Simulator()
    simulator.append(rod)
    simulator.constrain(rod).using(elastica.GeneralConstraint, constrained_position_idx=(0,))
    weight = np.array([*scene.gravity, 0.0])
    simulator.add_forcing_to(rod).using(elastica.GravityForces, acc_gravity=weight)
    simulator.finalize()
    return simulator, rod
