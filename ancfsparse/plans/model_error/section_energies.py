"""Energies of a solution by its forces in sections: those a model has, and those it neglects."""

from __future__ import annotations

import itertools
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam, ElasticBody, Scene
from ancfsparse.scene.joints.clamp import Clamp
from ancfsparse.scene.loads.loads import PointMoment

Array = NDArray[np.float64]


class Energies(NamedTuple):
    """Energies of a body by the forces in the middle of its elements, each (k,) [J].

    Attributes
    ----------
    bending, shear, axial : ndarray
        Of the bending moment, the shear force and the tension.
    bent, stretched : ndarray
        By how much measures of strain differ in bending and in tension: Green's strain gives
        1 + 3/2 eps times the tension of the change of length, to first order.
    tension : ndarray, shape (k, n_elements)
        The axial force there [N].
    """

    bending: Array
    shear: Array
    axial: Array
    bent: Array
    stretched: Array
    tension: Array


def energies_of(run: Trajectory, body: ElasticBody) -> Energies:
    """Evaluate the energies of a body over time."""
    force, strain = run.section_force(body), np.abs(run.strain(body))
    given, half = body.stiffnesses(), 0.5 * body.lengths

    def square(values: Array) -> Array:
        return np.asarray(np.square(values).reshape(*strain.shape, -1).sum(axis=2))

    bending = half * square(force.M) / given["bending_stiffness_z"]
    shear = half * square(force.Q) / given["shear_stiffness_y"]
    axial = half * np.square(force.N) / given["axial_stiffness"]
    bent, stretched = 2.0 * bending * strain, 1.5 * axial * strain
    return Energies(
        bending.sum(axis=1),
        shear.sum(axis=1),
        axial.sum(axis=1),
        bent.sum(axis=1),
        stretched.sum(axis=1),
        force.N,
    )


def torsion_energy(scene: Scene, run: Trajectory, body: ElasticBody) -> Array:
    """Return the energy of twist that joints and moments would put into a cable, (k,) [J].

    Without moments along it an isotropic rod has the same torsion everywhere.  It is that of a
    moment at its ends along the axis, or of the angle between the section that a clamp holds at
    the end and the one that is carried there from the other clamp without twist.
    """
    none = np.zeros(len(run.t))
    if not isinstance(body, Beam):
        return none
    twisting = float(np.mean(body.stiffnesses()["torsion_stiffness"])) / body.length
    tangents = directions(run, body)
    energy = none
    for load in scene.loads:
        if isinstance(load, PointMoment) and load.node.beam is body:
            moments = np.stack([load.at(t) for t in run.t])
            own = tangents[:, min(load.node.index, body.n_elements - 1)]
            energy = energy + np.einsum("kd,kd->k", moments, own) ** 2 / (2.0 * twisting)
    clamps = {joint.node.index for joint in scene.joints
              if isinstance(joint, Clamp) and joint.node.beam is body}  # fmt: skip
    if {0, body.n_nodes - 1} <= clamps:
        energy = energy + 0.5 * twisting * carried_angle(tangents, body) ** 2
    return cast(Array, energy)


def carried_angle(tangents: Array, body: Beam) -> Array:
    """Return the angle from e_y, carried along the axis without twist, to the clamped one, (k,)."""
    first, last = body.frames[0], body.frames[-1]
    carried = np.broadcast_to(first[1], (len(tangents), 3))
    ways = [np.broadcast_to(first[0], carried.shape), *np.moveaxis(tangents, 1, 0)]
    ways.append(np.broadcast_to(last[0], carried.shape))
    for a, b in itertools.pairwise(ways):
        # The smallest rotation from a to b, applied to what is at right angles to a.
        along = np.einsum("kd,kd->k", b, carried) / (1.0 + np.einsum("kd,kd->k", a, b))
        carried = carried - along[:, None] * (a + b)
    return np.asarray(np.arctan2(carried @ last[2], carried @ last[1]))


def rotary_energy(run: Trajectory, body: ElasticBody) -> Array:
    """Return the kinetic energy of the rotation of the sections of a cable, (k,) [J]."""
    along, faster = (_across(run, body, of) for of in (run.q, run.v))
    square = np.einsum("ked,ked->ke", along, along)
    stretching = np.einsum("ked,ked->ke", along, faster) ** 2 / square
    rates = (np.einsum("ked,ked->ke", faster, faster) - stretching) / square
    return np.asarray((0.5 * body.lengths * body.stiffnesses()["inertia_y"] * rates).sum(axis=1))


def folds(ways: Array, body: ElasticBody) -> tuple[Array, Array]:
    """Return how a string turns at its nodes, and what resists that.

    Parameters
    ----------
    ways : ndarray, shape (k, e, dim)
        Its `directions`.
    body : ElasticBody
        The string.

    Returns
    -------
    ndarray, shape (k, m, dim)
        Changes of direction between two elements in line.
    ndarray, shape (m,)
        Bending stiffness over the distance of their middles [N m].
    """
    after = {int(row): e for e, row in enumerate(body.ends[:, 0])}
    pairs = [(e, after[int(row)]) for e, row in enumerate(body.ends[:, 1]) if int(row) in after]
    one, other = np.array(pairs, dtype=int).reshape(-1, 2).T
    stiffness = np.broadcast_to(body.stiffnesses()["bending_stiffness_z"], body.n_elements)
    lengths = 0.5 * (body.lengths[one] + body.lengths[other])
    return ways[:, other] - ways[:, one], stiffness[one] / lengths


def directions(run: Trajectory, body: ElasticBody) -> Array:
    """Return unit vectors from the first to the second node of each element, (k, e, dim)."""
    ways = _across(run, body, run.q)
    return np.asarray(ways / np.linalg.norm(ways, axis=2)[:, :, None])


def _across(run: Trajectory, body: ElasticBody, of: Array) -> Array:
    """Return how much positions, or their rates, differ between ends of elements, (k, e, dim)."""
    system, states = run.system, np.asarray(of)
    places = system.elements(body).reshape(body.n_elements, 2, -1)
    first, last = np.moveaxis(places[:, :, system.kind_of(body).columns("r")], 1, 0)
    return np.asarray(states[:, last] - states[:, first])


def string_energies(
    run: Trajectory, body: ElasticBody, tension: Array | None = None
) -> tuple[Array, Array]:
    """Return what bending the polygons would take, and what their tension takes, each (k,) [J].

    The `tension` is that of `Energies`, if that was evaluated.
    """
    ways = directions(run, body)
    changes, stiffness = folds(ways, body)
    angles = 2.0 * np.arcsin(np.minimum(1.0, 0.5 * np.linalg.norm(changes, axis=2)))
    folded = (0.5 * stiffness * angles**2).sum(axis=1)
    lines = body.parts[body.ends[:, 0]]
    chords = np.zeros_like(ways)
    for line in np.unique(lines):
        own = lines == line
        mean = np.einsum("ked,e->kd", ways[:, own], body.lengths[own])
        chords[:, own] = (mean / np.linalg.norm(mean, axis=1)[:, None])[:, None]
    square = 2.0 - 2.0 * np.einsum("ked,ked->ke", ways, chords)  # of small angles
    pull = np.maximum(run.section_force(body).N if tension is None else tension, 0.0)
    return folded, (0.5 * pull * square * body.lengths).sum(axis=1)
