"""Exudyn, a compiled multibody code with ANCF cables: its settings, its models, and their runs.

Its cable measures ``|r'| - 1`` at five Gauss points and ``(r' x r'') / |r'|^2`` at three: the
discretisation of our ``thin`` with ``strain="biot"``.
"""

from __future__ import annotations

import contextlib
import io
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.scene import Beam, Scene
from ancfsparse.system import System
from ancfsparse.system.coordinates.state import State


class ExudynError(Exception):
    """Its solver gave up; the message is the reason."""


@dataclass(frozen=True)
class Setting:
    """Exudyn's settings for a step."""

    name: str  # for the table
    # modified Newton renews its Jacobian when residuals shrink by less than this factor; 0 takes
    # full Newton
    contractivity: float = 0.0
    linear_solver: str = "EigenDense"  # Exudyn's name for it
    reuse_pattern: bool = False  # whether a sparse solver orders its unknowns once only
    # of its generalised-alpha method at high frequencies; the trapezoidal rule if not given
    spectral_radius: float | None = None
    # Exudyn's name of an explicit method, which takes the place of all of the above
    explicit: str = ""
    # relative tolerance of an explicit method with automatic steps, of which the time step is the
    # largest; fixed steps if not given
    rtol: float | None = None
    # tolerances of Newton's method on the norm of the residual
    relative: float = 1e-8
    absolute: float = 1e-6


@dataclass(frozen=True)
class OtherRun:
    """Time, counts and positions of a run of Exudyn."""

    seconds: float  # of its solver alone [s]
    iterations_per_step: float  # Newton iterations per time step
    # (k, 2 n), positions of the watched nodes at the output times, without t = 0 [m]
    tip: Vector
    counts: dict[str, int]  # steps, Newton iterations and Jacobians


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
            "install the other codes, pip install 'ancfsparse[peers]'"
        ) from None


class Model:
    """A model of Exudyn: the cables of a scene and their weight, to which the rest is added.

    Parameters
    ----------
    scene : Scene
        Its beams become cables with the same nodes, stiffness, mass and start.
    start : State, optional
        Where the motion starts, if not in the reference shape.

    Attributes
    ----------
    nodes : dict of str to list of int
        Exudyn's numbers of the nodes of each cable.
    """

    def __init__(self, scene: Scene, start: State | None = None) -> None:
        self.exudyn, self.item = load(), import_module("exudyn.itemInterface")
        self._container = self.exudyn.SystemContainer()
        self.system = self._container.AddSystem()
        self._planar, self._weight = scene.dim == 2, [*scene.gravity, 0.0][:3]
        self._sensors: list[Any] = []
        self._fixed = self.coordinate(self.system.AddNode(self.item.NodePointGround()), 0)
        flat = System(scene, start)
        self.nodes = {
            beam.name: self._add_cable(beam, *(x[places] for x in (flat.q_ref, flat.q0, flat.v0)))
            for beam, places in zip(scene.bodies, flat.places, strict=True)
            if isinstance(beam, Beam)
        }

    def _add_cable(self, beam: Beam, reference: Vector, q: Vector, v: Vector) -> list[int]:
        item, given = self.item, beam.parameters()
        point = item.NodePoint2DSlope1 if self._planar else item.NodePointSlope1
        cable = item.ObjectANCFCable2D if self._planar else item.ObjectANCFCable
        values = (x.tolist() for x in (reference, q - reference, v))
        numbers = [
            self.system.AddNode(
                point(referenceCoordinates=a, initialCoordinates=b, initialVelocities=c)
            )
            for a, b, c in zip(*values, strict=True)
        ]
        for ends in pairwise(numbers):
            added = self.system.AddObject(
                cable(
                    length=given["length"],
                    massPerLength=given["mass_per_length"],
                    axialStiffness=given["axial_stiffness"],
                    bendingStiffness=given["bending_stiffness"],
                    nodeNumbers=list(ends),
                )
            )
            self.weigh(added)
        return numbers

    def weigh(self, body: int) -> None:
        """Apply gravity to a body."""
        if any(self._weight):
            marker = self.system.AddMarker(self.item.MarkerBodyMass(bodyNumber=body))
            self.system.AddLoad(
                self.item.LoadMassProportional(markerNumber=marker, loadVector=self._weight)
            )

    def coordinate(self, node: int, k: int) -> Any:
        """Return a marker at a coordinate of a node."""
        return self.system.AddMarker(self.item.MarkerNodeCoordinate(nodeNumber=node, coordinate=k))

    def add_mass(self, node: int, mass: float) -> None:
        """Add a point mass [kg] at a node of a planar cable."""
        matrix = np.diag([mass, mass, 0.0, 0.0])
        self.system.AddObject(self.item.ObjectGenericODE2(nodeNumbers=[node], massMatrix=matrix))

    def tie(self, node: int, k: int, other: int | None = None) -> Any:
        """Tie a coordinate to the same one of another node, or to where it is."""
        mate = self._fixed if other is None else self.coordinate(other, k)
        ends = [mate, self.coordinate(node, k)]
        return self.system.AddObject(self.item.CoordinateConstraint(markerNumbers=ends))

    def watch(self, node: int) -> None:
        """Store the positions of a node during the run."""
        position = self.exudyn.OutputVariableType.Position
        sensor = self.item.SensorNode(
            nodeNumber=node, storeInternal=True, writeToFile=False, outputVariableType=position
        )
        self._sensors.append(self.system.AddSensor(sensor))

    def run(
        self,
        setting: Setting,
        t_end: float,
        dt: float,
        interval: float,
        clock: Callable[[], float] = time.perf_counter,
    ) -> OtherRun:
        """Solve with one thread and no output.

        Parameters
        ----------
        setting : Setting
            How steps are solved.
        t_end, dt : float
            Simulated time and time step [s].
        interval : float
            Time between stored positions [s].
        clock : callable, optional
            Times the solver: wall time by default [s].

        Raises
        ------
        ExudynError
            If its solver gives up.
        """
        settings = _settings(self.exudyn, setting, t_end, dt)
        settings.solution.sensors.writePeriod = interval
        method = getattr(self.exudyn.DynamicSolverType, setting.explicit or "GeneralizedAlpha")
        with contextlib.redirect_stdout(io.StringIO()):  # it prints much when it fails
            self.system.Assemble()
            begin = clock()
            try:
                self.system.SolveDynamic(settings, solverType=method)
            except Exception as error:  # Exudyn documents no class for a solver that gives up
                at = self.system.sys["dynamicSolver"].it.currentTime
                raise ExudynError(f"gave up at t = {at:.2g} s") from error
            seconds = clock() - begin
        done = self.system.sys["dynamicSolver"].it
        counts = {
            "steps": int(done.currentStepIndex) - 1,
            "iterations": int(done.newtonStepsCount),
            "factorizations": int(done.newtonJacobiCount),
        }
        stored = [np.atleast_2d(self.system.GetSensorStoredData(each)) for each in self._sensors]
        tips = [each[each[:, 0] > 0.25 * interval, 1:3] for each in stored]
        tip = np.concatenate(tips, axis=1) if tips else np.zeros((0, 0))
        return OtherRun(seconds, counts["iterations"] / round(t_end / dt), tip, counts)


def _settings(exudyn: Any, setting: Setting, t_end: float, dt: float) -> Any:
    """Return Exudyn's settings: one thread, no output."""
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
    newton.relativeTolerance, newton.absoluteTolerance = setting.relative, setting.absolute
    return settings
