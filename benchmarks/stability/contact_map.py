"""The map of cables and nets in contact with obstacles, and its findings."""

from __future__ import annotations

import math

import numpy as np

from ancfsparse.results import Trajectory
from benchmarks.common import methods
from benchmarks.common.methods import chosen
from benchmarks.common.tables import group_by
from benchmarks.common.target import verdict
from benchmarks.stability.cells import MapPoint, Run
from benchmarks.stability.contact_scenes import SCENES, ContactCase
from benchmarks.stability.findings import MAX_LISTED, comparison, completed, describe, gains
from benchmarks.stability.map_spec import MapSpec
from benchmarks.stability.stability_map import Stability

SAMPLES = 4  # of the way of a point in a step, where penetrations are measured
MAX_DEPTH = 0.3  # penetration over the radius with the reference stiffness


def measure(path: Trajectory, case: ContactCase) -> tuple[float, float, float]:
    """Return depth, gain and loss [-]; see `CONTACTS`."""
    return largest_depth(path, case), *energy_changes(path)


def largest_depth(path: Trajectory, case: ContactCase) -> float:
    """Return the largest penetration of the points of a contact over their radius [-].

    The points are followed on straight ways from state to state, so one that passes through the
    obstacle within a step has its radius or more.  A body of the obstacle must not move but turn
    about the base.
    """
    contact = case.contact
    states = np.asarray(path.q)
    tables = [path.system.point(point) for point in contact.points]
    points = np.stack([states[:, where] @ weights for where, weights in tables], axis=1)
    paths = [points[:-1] + k / SAMPLES * np.diff(points, axis=0) for k in range(SAMPLES)]
    positions = np.concatenate([*paths, points[-1:]]).reshape(-1, points.shape[-1])
    return float(1.0 - contact.obstacle.distances(positions).min() / contact.radii[0])


def energy_changes(path: Trajectory) -> tuple[float, float]:
    """Return gain and loss of energy over the energy exchanged; see `CONTACTS`."""
    energy = path.energy
    above = energy.total - energy.total[0] - energy.work + energy.friction
    others = energy.elastic, energy.potential, energy.contact, energy.work, energy.friction
    exchanged = max(energy.kinetic.max(), *(np.abs(each - each[0]).max() for each in others))
    if exchanged == 0.0:
        return 0.0, 0.0
    return max(float(above.max() / exchanged), 0.0), max(float(-above[-1] / exchanged), 0.0)


CONTACTS = MapSpec(
    command="stability contact",
    varied="stiffness of contact",
    unit="",
    scenes=SCENES,
    stiffnesses=(0.01, 0.1, 1.0, 10.0, 100.0),
    steps=(1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3),
    integrators=chosen(
        methods.IMPLICIT,
        *("Newmark(0)", "GeneralizedAlpha(0.9)", "GeneralizedAlpha(0.5)", "EnergyMomentum"),
    ),
    solvers=chosen(
        methods.SOLVERS,
        *("Newton", "auto", "modified Newton", "bfgs, full"),
        *(f"{update}, {methods.PAIRS} pairs" for update in ("broyden", "bfgs")),
    ),
    for_all_integrators=("Newton", "auto"),
    for_all_solvers=("GeneralizedAlpha(0.9)", "EnergyMomentum"),
    t_end=0.12,
    max_steps=1000,
    # Largest penetration over the radius; largest energy above the supplied work with friction
    # counted as retained, and loss at the end, over the energy exchanged.
    measures=("depth", "gain", "loss"),
    measure=measure,
)


def depth_limit(run: Run) -> float:
    """Return the penetration over the radius beyond which a body sank in [-].

    An impact sinks in by the inverse root of the stiffness.
    """
    return MAX_DEPTH / math.sqrt(run.map_point.stiffness)


def select_unsolved(result: Stability) -> list[MapPoint]:
    """Return the points at which no solver comes to the end, without a solver."""
    points = group_by(result.runs, lambda run: run.map_point._replace(solver=""))
    return [point for point, runs in points.items() if not any(run.is_complete for run in runs)]


def findings(result: Stability) -> list[str]:
    """State the failures relative to Newton, hidden gains, and bodies that sink in."""
    complete = [run for run in result.runs if run.is_complete]
    deep = [run for run in complete if run.measures["depth"] > depth_limit(run)]
    by_stiffness = group_by(complete, lambda run: run.map_point.stiffness)
    deepest = (
        f"{max(run.measures['depth'] for run in runs):.2g} with {stiffness:g}"
        for stiffness, runs in sorted(by_stiffness.items())
    )
    friction = group_by(result.runs, lambda run: run.map_point.scene.partition(", ")[2])
    stiffness = group_by(result.runs, lambda run: f"stiffness {run.map_point.stiffness:g}")
    integrator = group_by(
        [run for run in result.runs if run.map_point.solver == "auto"],
        lambda run: f'{run.map_point.integrator} and "auto"',
    )
    groups = friction, stiffness, integrator
    unsolved = select_unsolved(result)
    soft = [describe(result, point) for point in unsolved if point.stiffness <= 1.0]
    return [
        *comparison(result),
        *gains(result, "of the energy exchanged above the supplied work", lambda run: ""),
        "Runs that do not come to their end: "
        + "; ".join(
            ", ".join(f"{100.0 - completed(runs):.3g} % with {name}" for name, runs in each.items())
            for each in groups
        )
        + ".",
        f"At {len(unsolved)} points no solver comes to the end, at {len(soft)} with the "
        "reference stiffness or less.",
        *(f"No solver comes to the end: {name}." for name in soft[:MAX_LISTED]),
        "Largest penetration over the radius of a run that came to its end, by the stiffness over "
        f"the reference one: {', '.join(deepest)}. Beyond {MAX_DEPTH:g} over the root of that "
        f"stiffness are {len(deep)} of {len(complete)} runs (target: none, {verdict(not deep)}).",
        *(
            f"Sank in: {describe(result, run.map_point)}: {run.measures['depth']:.2g} radii."
            for run in deep[:MAX_LISTED]
        ),
    ]
