"""The paper's pendulum in Exudyn, a compiled multibody code with a planar ANCF cable.

Its cable measures ``|r'| - 1`` at five Gauss points and ``(r' x r'') / |r'|^2`` at three: the
discretisation of our ``thin`` with ``strain="biot"``.
"""

from __future__ import annotations

import contextlib
import io
import sys
import time
from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.problems import Problem

IMMOVABLE = 1e14  # mass that stands for a pin [kg]


class ExudynError(Exception):
    """Its solver gave up; the message is the reason."""


@dataclass(frozen=True)
class Setting:
    """How Exudyn solves a step.

    Attributes
    ----------
    name : str
        For the table.
    contractivity : float
        Modified Newton renews its Jacobian when residuals shrink by less than this factor; 0 takes
        full Newton.
    linear_solver : str
        Exudyn's name for it.
    reuse_pattern : bool, optional
        Whether a sparse solver orders its unknowns once only.
    spectral_radius : float, optional
        Of its generalised-alpha method at high frequencies; the trapezoidal rule if not given.
    explicit : str, optional
        Exudyn's name of an explicit method, which takes the place of all of the above.
    rtol : float, optional
        Relative tolerance of an explicit method with automatic steps, of which the time step is
        the largest; fixed steps if not given.
    """

    name: str
    contractivity: float = 0.0
    linear_solver: str = "EigenDense"
    reuse_pattern: bool = False
    spectral_radius: float | None = None
    explicit: str = ""
    rtol: float | None = None


SETTINGS = (
    Setting("Exudyn, modified 0.02, dense", 0.02, "EigenDense"),
    Setting("Exudyn, modified 0.02, sparse", 0.02, "EigenSparse"),
    Setting("Exudyn, modified 0.05, sparse", 0.05, "EigenSparse"),
    Setting("Exudyn, full Newton, dense", 0.0, "EigenDense"),
)
"""Its fastest settings for ten elements, of all that were tried."""


@dataclass(frozen=True)
class PeerRun:
    """What a run of Exudyn took and found.

    Attributes
    ----------
    seconds : float
        Wall time of its solver alone [s].
    iterations_per_step : float
        Newton iterations per time step.
    tip : (k, 2) float
        Tip at whole multiples of the interval asked for, t = 0 left out [m].
    counts : dict of str to int
        Steps, Newton iterations and Jacobians.
    """

    seconds: float
    iterations_per_step: float
    tip: NDArray[np.float64]
    counts: dict[str, int]


def load() -> Any:
    """Return the module, its fast variant where the processor has AVX2.

    Raises
    ------
    InputError
        If it is not installed.
    """
    sys.exudynFast = True  # type: ignore[attr-defined]  # read by exudyn when first imported
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            return import_module("exudyn")
    except ImportError as error:
        raise InputError(
            f"Exudyn, the program to compare with, cannot be imported ({error}): "
            "install the peers, pip install 'ancfsparse[peers]'"
        ) from None


def run_exudyn(
    problem: Problem, setting: Setting, t_end: float, dt: float, interval: float
) -> PeerRun:
    """Simulate a planar cable pinned at its start with Exudyn.

    Parameters
    ----------
    problem : Problem
        A planar pendulum; mesh, stiffness and gravity are taken from it.
    setting : Setting
        How steps are solved.
    t_end, dt : float
        Simulated time and time step [s].
    interval : float
        Time between stored tips [s].

    Raises
    ------
    ExudynError
        If its solver gives up.
    """
    exudyn = load()
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    tip = _build(system, problem, heavy=bool(setting.explicit))
    sensor = _watch(exudyn, system, tip)
    system.Assemble()
    settings = settings_of(exudyn, setting, t_end, dt)
    settings.solution.sensors.writePeriod = interval
    method = getattr(exudyn.DynamicSolverType, setting.explicit or "GeneralizedAlpha")
    begin = time.perf_counter()
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # it says much when it fails
            system.SolveDynamic(settings, solverType=method)
    except Exception as error:  # Exudyn documents no class for a solver that gives up
        at = system.sys["dynamicSolver"].it.currentTime
        raise ExudynError(f"gave up at t = {at:.2g} s") from error
    seconds = time.perf_counter() - begin
    done = system.sys["dynamicSolver"].it
    counts = {
        "steps": int(done.currentStepIndex) - 1,
        "iterations": int(done.newtonStepsCount),
        "factorizations": int(done.newtonJacobiCount),
    }
    stored = np.atleast_2d(system.GetSensorStoredData(sensor))
    tips = stored[stored[:, 0] > 0.0, 1:3]
    return PeerRun(seconds, counts["iterations"] / round(t_end / dt), tips, counts)


def _build(system: Any, problem: Problem, heavy: bool) -> int:
    """Add nodes, cables, weight and pin; return the last node.

    With a pinned coordinate its explicit methods converge to another motion, so `heavy` pins by a
    mass that nothing moves.
    """
    item = import_module("exudyn.itemInterface")
    rod = problem.rod
    given = rod.parameters()
    length = rod.length / rod.n_elements
    nodes = [
        system.AddNode(item.NodePoint2DSlope1(referenceCoordinates=[i * length, 0.0, 1.0, 0.0]))
        for i in range(rod.n_nodes)
    ]
    for ends in pairwise(nodes):
        cable = system.AddObject(
            item.ObjectANCFCable2D(
                length=length,
                massPerLength=given["mass_per_length"],
                axialStiffness=given["axial_stiffness"],
                bendingStiffness=given["bending_stiffness"],
                nodeNumbers=list(ends),
            )
        )
        marker = system.AddMarker(item.MarkerBodyMass(bodyNumber=cable))
        weight = [*problem.scene.gravity, 0.0]
        system.AddLoad(item.LoadMassProportional(markerNumber=marker, loadVector=weight))
    if heavy:
        mass = np.diag([IMMOVABLE, IMMOVABLE, 0.0, 0.0])
        system.AddObject(item.ObjectGenericODE2(nodeNumbers=nodes[:1], massMatrix=mass))
        return int(nodes[-1])
    ground = system.AddNode(item.NodePointGround())
    fixed = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    for coordinate in (0, 1):
        held = system.AddMarker(
            item.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate)
        )
        system.AddObject(item.CoordinateConstraint(markerNumbers=[fixed, held]))
    return int(nodes[-1])


def _watch(exudyn: Any, system: Any, node: int) -> Any:
    item = import_module("exudyn.itemInterface")
    return system.AddSensor(
        item.SensorNode(
            nodeNumber=node,
            storeInternal=True,
            writeToFile=False,
            outputVariableType=exudyn.OutputVariableType.Position,
        )
    )


def settings_of(exudyn: Any, setting: Setting, t_end: float, dt: float) -> Any:
    """Return Exudyn's settings: one thread, no output.

    Parameters
    ----------
    exudyn : module
        As `load` returns it.
    setting : Setting
        How steps are solved.
    t_end, dt : float
        Simulated time and time step [s].
    """
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.linearSolver.solverType = getattr(exudyn.LinearSolverType, setting.linear_solver)
    settings.linearSolver.reuseAnalyzedPattern = setting.reuse_pattern
    settings.parallel.numberOfThreads = 1
    stepping = settings.timeIntegration
    stepping.numberOfSteps = round(t_end / dt)
    stepping.endTime = t_end
    stepping.verboseMode = stepping.stepInformation = 0
    stepping.adaptiveStep = False
    if setting.explicit:
        stepping.automaticStepSize = setting.rtol is not None
        stepping.explicit.computeEndOfStepAccelerations = False
        if setting.rtol is not None:
            stepping.relativeTolerance = stepping.absoluteTolerance = setting.rtol
            stepping.minimumStepSize = 1e-9
    stepping.generalizedAlpha.useNewmark = setting.spectral_radius is None
    if setting.spectral_radius is not None:
        stepping.generalizedAlpha.spectralRadius = setting.spectral_radius
    stepping.generalizedAlpha.useIndex2Constraints = False
    newton = stepping.newton
    newton.useModifiedNewton = setting.contractivity > 0.0
    if newton.useModifiedNewton:
        newton.modifiedNewtonContractivity = setting.contractivity
    newton.relativeTolerance, newton.absoluteTolerance = 1e-8, 1e-6
    return settings
