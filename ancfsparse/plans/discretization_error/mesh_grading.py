"""Graded meshes with fewer elements for the same error, from a trial run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ancfsparse.plans.models.graded_mesh import (
    ENERGY_ORDER,
    UNIFORM,
    MeshGrading,
    energy_error,
    equidistributed,
    error_density,
)
from ancfsparse.plans.models.model import inner_node_positions, open_bodies
from ancfsparse.plans.trial_runs.trial_runs import TrialRun
from ancfsparse.scene import Beam, Scene
from ancfsparse.system import System

MIN_GRADING_GAIN = 1.5  # elements of a uniform mesh over those of a graded one
MAX_STATES = 64  # of a motion that are evaluated
SAME_POSITION = 1e-9  # relative distance of a node from a position with a force
NOISE = 1e-9  # interpolation error over the length of the beam that is rounding


def grade_meshes(scene: Scene, trial: TrialRun) -> tuple[dict[str, MeshGrading], float]:
    """Grade the meshes of all automatic beams by a trial run.

    Returns
    -------
    dict of str to MeshGrading
        By the name of the beam; empty if elements are not cables, or the run shows no error.
    float
        Elements of the mesh of the trial run over those of graded meshes with the same error.
    """
    beams = {beam.name: beam for beam in open_bodies(scene) if beam.name in trial.model.counts}
    forces = inner_node_positions(scene, beams)
    out: dict[str, MeshGrading] = {}
    present = graded = 0.0
    for name in beams:
        body = trial.run.system.scene.body(name)
        if not (isinstance(body, Beam) and body.kind.is_cable):
            return {}, 1.0
        nodes = np.linspace(0.0, 1.0, body.n_elements + 1)
        if body.nodes is not None:
            nodes = np.array(body.nodes)
        f = _density(trial, body, nodes, forces[name])
        grading = trial.model.gradings.get(name, UNIFORM)
        out[name] = equidistributed(f, nodes) if f.any() else grading
        stiffness = float(np.mean(body.stiffnesses()["bending_stiffness_z"])) * body.length
        present += stiffness * energy_error(f, nodes, grading)
        graded += stiffness * energy_error(f, nodes, out[name])
    return (out, float((present / graded) ** (1.0 / ENERGY_ORDER))) if graded > 0.0 else ({}, 1.0)


def _density(trial: TrialRun, body: Beam, nodes: np.ndarray, forces: list[float]) -> np.ndarray:
    """Return the error density of the elements of a beam; zero where that is rounding."""
    system = trial.run.system
    assert isinstance(system, System)
    i = system.bodies.index(body)
    every = max(1, len(trial.run.t) // MAX_STATES)
    q = np.asarray(trial.run.q)[::every]
    r, slopes = (q[:, system.vectors(each)[i]] for each in ("r", "r_x"))
    distances = np.abs(nodes[:, None] - np.array(forces))
    f = error_density(r, slopes, body.lengths, distances.min(axis=1, initial=1.0) < SAME_POSITION)
    return np.where(body.lengths**4 * np.sqrt(f) > NOISE * body.length, f, 0.0)


def describe_gradings(gradings: Mapping[str, MeshGrading]) -> str:
    """Return a sentence on graded meshes."""
    name, steepest = max(gradings.items(), key=lambda item: item[1].length_ratio)
    return (
        f"the bending of {name} is concentrated, so its elements there are up to "
        f"{steepest.length_ratio:.2g} times shorter than elsewhere"
    )
