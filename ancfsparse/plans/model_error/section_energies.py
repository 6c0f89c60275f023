"""Energies of a solution from its section forces, both retained and neglected by a model."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.plans.models.rigid_links import references
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam, ElasticBody, Point, Scene
from ancfsparse.scene.joints.clamp import Clamp
from ancfsparse.scene.loads.loads import PointMoment
from ancfsparse.scene.records.record import PointRef

MAX_STRAIN_SPREAD = 1.7  # between measures of strain, over M^2/(EI EA), see `strain_spread`


class SectionEnergies(NamedTuple):
    """Energies of a body from the section forces in the middle of its elements, each (k,) [J].

    Attributes
    ----------
    bending, axial, shear : ndarray
        Of the bending moment, the tension and the shear force.
    spread : ndarray
        Difference between measures of strain: to first order, Green's strain gives 1 + 3/2 eps
        times the tension of the change of length, and 1 + 2 eps times the bending energy.
    """

    bending: Vector
    axial: Vector
    shear: Vector
    spread: Vector


def section_energies(
    run: Trajectory, body: ElasticBody, before: Trajectory | None = None
) -> SectionEnergies:
    """Evaluate the energies of a body over time, or of its changes from an earlier run."""
    force, strain = run.section_force(body), np.abs(run.strain(body))
    if before is not None:
        other = before.section_force(body)
        force = replace(force, N=force.N - other.N, Q=force.Q - other.Q, M=force.M - other.M)
    given, half = body.stiffnesses(), 0.5 * body.lengths

    def square(values: Vector) -> Vector:
        return np.asarray(np.square(values).reshape(*strain.shape, -1).sum(axis=2))

    bending = half * square(force.M) / given["bending_stiffness_z"]
    shear = half * square(force.Q) / given["shear_stiffness_y"]
    axial = half * np.square(force.N) / given["axial_stiffness"]
    spread = (2.0 * bending + 1.5 * axial) * strain
    return SectionEnergies(*(each.sum(axis=1) for each in (bending, axial, shear, spread)))


def strain_spread(run: Trajectory, body: ElasticBody, point: Point) -> float:
    """Return the largest difference over time between measures of the strain of a bent axis [-].

    Bending energy that depends on stretch adds c M^2/(EI EA) to the strain by tension, with c = 1
    for cables with Green's strain, 0 with Biot's, and a measured -.7 for thick beams.
    """
    given, moment = body.stiffnesses(), run.section_force(body, [point]).M
    square = np.square(moment).reshape(len(run.t), -1).sum(axis=1).max()
    stiffness = np.mean(given["bending_stiffness_z"]) * np.mean(given["axial_stiffness"])
    return MAX_STRAIN_SPREAD * float(square / stiffness)


def torsion_energy(run: Trajectory, body: ElasticBody) -> Vector:
    """Return the torsional energy of a cable by moments and clamps, (k,) [J].

    Without distributed moments an isotropic rod has constant torsion.  It is that of moments along
    the axis at its ends, or of the angle between the section clamped at one end and the section
    that is transported there from the other clamp without twist.
    """
    energy, scene = np.zeros(len(run.t)), run.system.scene
    if not isinstance(body, Beam) or scene.dim == 2:
        return energy
    twisting = float(np.mean(body.stiffnesses()["torsion_stiffness"])) / body.length
    tangents = directions(run, body)
    for load in scene.loads:
        if isinstance(load, PointMoment) and load.node.beam is body:
            moments = np.stack([load.at(t) for t in run.t])
            axis = tangents[:, min(load.node.index, body.n_elements - 1)]
            energy = energy + np.einsum("kd,kd->k", moments, axis) ** 2 / (2.0 * twisting)
    clamps = {joint.node.index for joint in scene.joints
              if isinstance(joint, Clamp) and joint.node.beam is body}  # fmt: skip
    if {0, body.n_nodes - 1} <= clamps:
        energy = energy + 0.5 * twisting * transported_angle(tangents, body) ** 2
    return cast(Vector, energy)


def transported_angle(tangents: Vector, body: Beam) -> Vector:
    """Return the angle from e_y, transported without twist, to the clamped one, (k,)."""
    first, last = body.frames[0], body.frames[-1]
    carried = np.broadcast_to(first[1], (len(tangents), 3))
    axes = [np.broadcast_to(first[0], carried.shape), *np.moveaxis(tangents, 1, 0)]
    axes.append(np.broadcast_to(last[0], carried.shape))
    for a, b in itertools.pairwise(axes):
        # The smallest rotation from a to b, applied to a vector normal to a.
        along = np.einsum("kd,kd->k", b, carried) / (1.0 + np.einsum("kd,kd->k", a, b))
        carried = carried - along[:, None] * (a + b)
    return np.asarray(np.arctan2(carried @ last[2], carried @ last[1]))


def rotary_energy(run: Trajectory, body: ElasticBody, v: Vector | None = None) -> Vector:
    """Return the kinetic energy of the rotation of the sections of a cable, (k,) [J].

    With velocities `v`, if given, in place of the run's.
    """
    along, rate = (_end_differences(run, body, x) for x in (run.q, run.v if v is None else v))
    square = np.einsum("ked,ked->ke", along, along)
    stretching = np.einsum("ked,ked->ke", along, rate) ** 2 / square
    rates = (np.einsum("ked,ked->ke", rate, rate) - stretching) / square
    return np.asarray((0.5 * body.lengths * body.stiffnesses()["inertia_y"] * rates).sum(axis=1))


def loaded_nodes(scene: Scene) -> dict[str, set[int]]:
    """Return the nodes of every body at which forces, joints and force elements act."""
    nodes: dict[str, set[int]] = {body.name: set() for body in scene.bodies}
    for reference in references(scene.records):
        if isinstance(reference, PointRef) and reference.xi == 0.0:
            nodes[reference.body].add(reference.index)
    return nodes


class Folds(NamedTuple):
    """Changes of direction of a string at its nodes.

    Attributes
    ----------
    changes : ndarray, shape (k, m, dim)
        Differences of the unit vectors along successive elements.
    stiffness : ndarray, shape (m,)
        Bending stiffness [N m2].
    lengths : ndarray, shape (k, m)
        Lengths over which the string would bend [m]: the distance of the midpoints of the
        elements, or at nodes with forces, where bending stiffness B rounds the kink by
        exp(-s / a) with a = sqrt(B / N), 2 a if that is less.
    is_kink : ndarray of bool, shape (m,)
        Nodes with forces.
    """

    changes: Vector
    stiffness: Vector
    lengths: Vector
    is_kink: NDArray[np.bool_]


def folds(run: Trajectory, body: ElasticBody, loaded: set[int], tension: Vector) -> Folds:
    """Return the changes of direction of a string with a tension [N], and forces at some nodes."""
    after = {int(row): e for e, row in enumerate(body.ends[:, 0])}
    pairs = [(e, after[int(row)]) for e, row in enumerate(body.ends[:, 1]) if int(row) in after]
    one, other = np.array(pairs, dtype=int).reshape(-1, 2).T
    stiffness = np.broadcast_to(body.stiffnesses()["bending_stiffness_z"], body.n_elements)[one]
    lengths = 0.5 * (body.lengths[one] + body.lengths[other])
    is_kink = np.isin(body.row_nodes[body.ends[one, 1]], sorted(loaded))
    force = np.maximum(0.5 * (tension[:, one] + tension[:, other]), 0.0)
    rounded = lengths / np.maximum(1.0, 0.5 * lengths * np.sqrt(force / stiffness))
    tangents = directions(run, body)
    return Folds(
        tangents[:, other] - tangents[:, one],
        stiffness,
        np.where(is_kink, rounded, lengths),
        is_kink,
    )


def directions(run: Trajectory, body: ElasticBody) -> Vector:
    """Return unit vectors from the first to the second node of each element, (k, e, dim)."""
    chords = _end_differences(run, body, run.q)
    return np.asarray(chords / np.linalg.norm(chords, axis=2)[:, :, None])


def _end_differences(run: Trajectory, body: ElasticBody, x: Vector) -> Vector:
    """Return the differences of positions, or of their rates, over the elements, (k, e, dim)."""
    system, states = run.system, np.asarray(x)
    indices = system.elements(body).reshape(body.n_elements, 2, -1)
    first, last = np.moveaxis(indices[:, :, system.kind_of(body).columns("r")], 1, 0)
    return np.asarray(states[:, last] - states[:, first])


def string_energies(
    run: Trajectory, body: ElasticBody, loaded: set[int]
) -> tuple[Vector, Vector, Vector]:
    """Return the energies of bending and tension of the polygons of a string, each (k,) [J].

    And the largest displacement, (k,) [m], by the rounding of its kinks at the `loaded` nodes.
    """
    force = run.section_force(body).N
    corners = folds(run, body, loaded, force)
    angles = 2.0 * np.arcsin(np.minimum(1.0, 0.5 * np.linalg.norm(corners.changes, axis=2)))
    bending = (0.5 * corners.stiffness / corners.lengths * angles**2).sum(axis=1)
    cut = 0.25 * (angles * corners.lengths)[:, corners.is_kink].max(axis=1, initial=0.0)
    tangents = directions(run, body)
    lines = body.parts[body.ends[:, 0]]
    chords = np.zeros_like(tangents)
    for line in np.unique(lines):
        rows = lines == line
        mean = np.einsum("ked,e->kd", tangents[:, rows], body.lengths[rows])
        chords[:, rows] = (mean / np.linalg.norm(mean, axis=1)[:, None])[:, None]
    square = 2.0 - 2.0 * np.einsum("ked,ked->ke", tangents, chords)  # of small angles
    stretching = (0.5 * np.maximum(force, 0.0) * square * body.lengths).sum(axis=1)
    return bending, stretching, cut
