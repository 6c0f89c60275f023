"""A scene of cables in Exudyn, cable by cable, with the same start."""

from __future__ import annotations

import time
from importlib import import_module
from itertools import pairwise
from typing import Any

from ancfsparse.errors import InputError
from ancfsparse.scene import Beam, Connect, Node, Pin, Scene
from ancfsparse.studies.peers.exudyn import Setting, load, settings_of
from ancfsparse.system import System

SETTINGS = (
    Setting("Exudyn, modified Newton", 0.5, "EigenSparse", reuse_pattern=True),
    Setting("Exudyn, full Newton", 0.0, "EigenSparse", reuse_pattern=True),
)
"""Its fastest settings for large meshes, of all that were tried."""

# Norm of the residual that is small enough; 1e-6 lies below the rounding of 1e4 elements.
ABSOLUTE_TOLERANCE = 1e-4


def march_exudyn(scene: Scene, setting: Setting, dt: float, steps: int) -> dict[str, float]:
    """Simulate pinned and connected cables with Exudyn's trapezoidal rule.

    Parameters
    ----------
    scene : Scene
        Cables, pins and connections under gravity.
    setting : Setting
        How steps are solved.
    dt : float
        Time step [s].
    steps : int
        Number of steps.

    Returns
    -------
    dict
        ``seconds`` of its solver alone and ``set_up_seconds`` before it [s],
        ``iterations_per_step`` and ``factorizations``.

    Raises
    ------
    InputError
        If its solver gives up.
    """
    exudyn = load()
    begin = time.perf_counter()
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    _build(system, scene)
    system.Assemble()
    settings = settings_of(exudyn, setting, steps * dt, dt)
    settings.timeIntegration.newton.absoluteTolerance = ABSOLUTE_TOLERANCE
    set_up = time.perf_counter() - begin
    begin = time.perf_counter()
    try:
        system.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.GeneralizedAlpha)
    except Exception as error:  # Exudyn documents no class for a solver that gives up
        raise InputError(f"Exudyn did not finish: {str(error).splitlines()[0]}") from error
    seconds = time.perf_counter() - begin
    done = system.sys["dynamicSolver"].it
    return {
        "seconds": seconds,
        "set_up_seconds": set_up,
        "iterations_per_step": done.newtonStepsCount / steps,
        "factorizations": done.newtonJacobiCount,
    }


def _build(system: Any, scene: Scene) -> None:
    """Add nodes, cables, weights, pins and connections."""
    item = import_module("exudyn.itemInterface")
    planar = scene.dim == 2
    point = item.NodePoint2DSlope1 if planar else item.NodePointSlope1
    cable = item.ObjectANCFCable2D if planar else item.ObjectANCFCable
    weight = [*scene.gravity, 0.0][:3]
    flat = System(scene)
    nodes = {}
    for beam, places in zip(scene.beams, flat.places, strict=True):
        if not isinstance(beam, Beam):
            raise InputError(f"{beam!r} is not handed to Exudyn: make it of beams")
        given = beam.parameters()
        numbers = nodes[beam.name] = [
            system.AddNode(point(referenceCoordinates=q, initialVelocities=v))
            for q, v in zip(flat.q0[places].tolist(), flat.v0[places].tolist(), strict=True)
        ]
        for ends in pairwise(numbers):
            added = system.AddObject(
                cable(
                    length=given["length"],
                    massPerLength=given["mass_per_length"],
                    axialStiffness=given["axial_stiffness"],
                    bendingStiffness=given["bending_stiffness"],
                    nodeNumbers=list(ends),
                )
            )
            marker = system.AddMarker(item.MarkerBodyMass(bodyNumber=added))
            system.AddLoad(item.LoadMassProportional(markerNumber=marker, loadVector=weight))
    ground = system.AddNode(item.NodePointGround())
    fixed = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))

    def coordinate(node: Node, d: int) -> Any:
        number = nodes[node.beam.name][node.index]
        return system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=number, coordinate=d))

    for joint in scene.joints:
        for d in range(scene.dim):
            if isinstance(joint, Pin):
                ends = fixed, coordinate(joint.node, d)
            elif isinstance(joint, Connect):
                ends = coordinate(joint.a, d), coordinate(joint.b, d)
            else:
                raise InputError(f"a {type(joint).__name__} is not handed to Exudyn")
            system.AddObject(item.CoordinateConstraint(markerNumbers=list(ends)))
