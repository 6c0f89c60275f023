"""What a model neglects, estimated from its own solution: no run of the richer model is needed.

Forces in sections of the cheap solution give the energy of what is neglected; over the energy that
is kept it is, to first order, the relative change of the compliance or of the inertia.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import ApproximateModes
from ancfsparse.plans.quantities import Position, Quantity
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam, Body, ElasticBody, Scene
from ancfsparse.scene.joints import Clamp
from ancfsparse.scene.loads import PointMoment
from ancfsparse.solve.modes import modes

Array = NDArray[np.float64]
March = Callable[[Scene], Trajectory]

# Relative change of stiffness or density with which the response of a quantity is measured.
PROBE = 0.01


def neglected_effects(
    scene: Scene, run: Trajectory, quantity: Quantity, march: March | None = None
) -> dict[str, float]:
    """Estimate by how much a quantity would change with what the model of a run neglects.

    Parameters
    ----------
    scene : Scene
        The scene of the run.
    run : Trajectory
        Its motion, or what `quasi_static` returned.
    quantity : Quantity
        What is asked for, of this scene.
    march : callable, optional
        Runs a changed scene as `run` was run.  With it, two runs with slightly softer and slightly
        denser material show how the quantity responds; without, it is taken to respond as much as
        it is large, which is pessimistic for beams that turn more than they bend.

    Returns
    -------
    dict of str to float
        Largest change over time [unit of the quantity], by effect.

        - ``"shear"``: of cables, whose sections stay at right angles to the axis.
        - ``"torsion"``: of cables in space.
        - ``"rotary inertia"``: of cables, whose mass is on their axis.
        - ``"stretch"``: by which converged elements differ, since their bending depends on it.
        - ``"bending"``: of strings.
        - ``"inertia"``: of a quasi-static run.

        An effect that the model includes is left out.

    Notes
    -----
    Energies that are neglected over those that are kept, integrated over the beams and largest over
    time: shear ``Q^2/kGA : M^2/EI``, torsion ``T^2/GJ : M^2/EI``, rotary inertia ``rho I w^2 : rho
    A v^2`` with the angular velocity w of the axis, stretch ``2 eps M^2/EI : M^2/EI``, bending of
    strings ``EI kappa^2 : N phi^2`` with the curvature of the polygon and its angle phi to the
    chord.  Inertia: ``2 y'' / omega^2`` for a quantity y and the lowest frequency, and ``y' /
    omega`` for what sets in with a rate.  Beside richer models they are right within a factor of 2
    where the effect is below 10 % (tests/plans/test_neglected.py).
    """
    beams = [b for b in scene.beams if isinstance(b, ElasticBody)]
    cables = [b for b in beams if b.kind.is_cable]
    strings = [b for b in beams if b.kind.is_string]
    shares: dict[str, float] = {}
    if cables:
        bending, shear, stretch = (np.zeros(len(run.t)) for _ in range(3))
        for body in cables:
            one, two, three = _cable_energies(run, body)
            bending, shear, stretch = bending + one, shear + two, stretch + three
        shares["shear"] = _ratio(shear, bending)
        if scene.dim == 3:
            shares["torsion"] = _ratio(sum(_torsion(scene, run, b) for b in cables), bending)
        shares["stretch"] = _ratio(stretch, bending)
    if strings:
        folded, held = (np.zeros(len(run.t)) for _ in range(2))
        for body in strings:
            one, two = _string_energies(run, body)
            folded, held = folded + one, held + two
        shares["bending"] = _ratio(folded, held)
    still = "integrator" not in run.settings and not np.asarray(run.v).any()
    heavy = 0.0 if still or not cables else _rotary(run, cables)
    soft, dense = _responses(scene, run, quantity, march)
    effects = {name: soft * share for name, share in shares.items()}
    if strings:  # tension resists, which material does not change
        effects["bending"] = shares["bending"] * _size(quantity, run)
    if cables and not still:
        effects["rotary inertia"] = dense * heavy
    if still and len(run.t) > 2:
        effects["inertia"] = _inertia(scene, run, quantity)
    return effects


def _ratio(neglected: Any, kept: Array) -> float:
    """Return the largest energies over time beside one another; nothing neglected is nothing."""
    most = float(np.max(neglected))
    if most <= 0.0:
        return 0.0
    return most / float(np.max(kept)) if np.max(kept) > 0.0 else np.inf


def _responses(
    scene: Scene, run: Trajectory, quantity: Quantity, march: March | None
) -> tuple[float, float]:
    """Return the change of the quantity over the relative change of compliance, and of density."""
    if march is None:
        return (_size(quantity, run),) * 2
    found = []
    for name, factor in (("youngs_modulus", 1.0 - PROBE), ("density", 1.0 + PROBE)):
        changed = scene
        for body in scene.beams:
            own = cast(ElasticBody, changed.counterpart(body))
            value = factor * getattr(own.material, name)
            changed = changed.replaced(own, material=replace(own.material, **{name: value}))
        other = quantity.on(changed)
        off = quantity.difference(other.value(march(changed)), quantity.value(run))
        found.append(float(np.linalg.norm(off, axis=1).max()) / PROBE)
    return found[0], found[1]


def _size(quantity: Quantity, run: Trajectory) -> float:
    """Return how large a quantity is; of a position how far it is from the reference shape."""
    history = quantity.history(run)
    size = quantity.size(history)
    if isinstance(quantity, Position):
        apart = np.linalg.norm(history - quantity.point.position, axis=1)
        size = max(size, float(apart.max()))
    return size


def _cable_energies(run: Trajectory, body: ElasticBody) -> tuple[Array, Array, Array]:
    """Return energies of bending and shear, and of bending times strain, each (k,) [J]."""
    force, strain = run.section_force(body), run.strain(body)
    k = len(run.t)
    each = np.square(force.M).reshape(k, body.n_elements, -1).sum(axis=2)
    across = np.square(force.Q).reshape(k, body.n_elements, -1).sum(axis=2)
    given = body.stiffnesses()
    bending = 0.5 * body.lengths * each / given["bending_stiffness_z"]
    shear = 0.5 * body.lengths * across / given["shear_stiffness_y"]
    return bending.sum(axis=1), shear.sum(axis=1), (2.0 * bending * np.abs(strain)).sum(axis=1)


def _torsion(scene: Scene, run: Trajectory, body: ElasticBody) -> Array:
    """Return the energy of twist that joints and moments would put into a cable, (k,) [J].

    Without moments along it an isotropic rod has the same torsion everywhere.  It is that of a
    moment at its ends along the axis, or of the angle between the section that a clamp holds at
    the end and the one that is carried there from the other clamp without twist.
    """
    none = np.zeros(len(run.t))
    if not isinstance(body, Beam):
        return none
    twisting = float(np.mean(body.stiffnesses()["torsion_stiffness"])) / body.length
    lines = np.stack([run.position(body.node(i)) for i in range(body.n_nodes)], axis=1)
    tangents = np.diff(lines, axis=1)
    tangents /= np.linalg.norm(tangents, axis=2)[:, :, None]
    energy = none
    for load in scene.loads:
        if isinstance(load, PointMoment) and load.node.beam is body:
            moments = np.stack([load.at(t) for t in run.t])
            own = tangents[:, min(load.node.index, body.n_elements - 1)]
            energy = energy + np.einsum("kd,kd->k", moments, own) ** 2 / (2.0 * twisting)
    clamps = {joint.node.index for joint in scene.joints
              if isinstance(joint, Clamp) and joint.node.beam is body}  # fmt: skip
    if {0, body.n_nodes - 1} <= clamps:
        energy = energy + 0.5 * twisting * _carried_angle(tangents, body) ** 2
    return cast(Array, energy)


def _carried_angle(tangents: Array, body: Beam) -> Array:
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


def _rotary(run: Trajectory, cables: list[ElasticBody]) -> float:
    """Return the kinetic energy of the rotation of sections over all of it."""
    turning = np.zeros(len(run.t))
    for body in cables:
        rows = range(body.n_nodes)
        r = np.stack([run.position(body.node(i)) for i in rows], axis=1)[:, _edges(body)]
        v = np.stack([run.velocity(body.node(i)) for i in rows], axis=1)[:, _edges(body)]
        along, faster = r[:, :, 1] - r[:, :, 0], v[:, :, 1] - v[:, :, 0]
        square = np.einsum("ked,ked->ke", along, along)
        stretching = np.einsum("ked,ked->ke", along, faster) ** 2 / square
        rates = (np.einsum("ked,ked->ke", faster, faster) - stretching) / square
        given = body.stiffnesses()
        turning += (0.5 * body.lengths * given["inertia_y"] * rates).sum(axis=1)
    return _ratio(turning, np.asarray(run.energy.kinetic))


def _edges(body: Body) -> NDArray[np.int32]:
    """Return the two nodes of every element, (n_elements, 2)."""
    return np.asarray(body.row_nodes[body.ends])


def _string_energies(run: Trajectory, body: ElasticBody) -> tuple[Array, Array]:
    """Return what bending the polygons would take, and what their tension takes, each (k,) [J]."""
    edges = _edges(body)
    r = np.stack([run.position(body.node(i)) for i in range(body.n_nodes)], axis=1)
    ways = r[:, edges[:, 1]] - r[:, edges[:, 0]]
    ways /= np.linalg.norm(ways, axis=2)[:, :, None]
    after = {int(row): e for e, row in enumerate(body.ends[:, 0])}
    pairs = [(e, after[int(row)]) for e, row in enumerate(body.ends[:, 1]) if int(row) in after]
    given = body.stiffnesses()
    stiffness = np.broadcast_to(given["bending_stiffness_z"], body.n_elements)
    folded = np.zeros(len(run.t))
    if pairs:
        one, other = np.array(pairs).T
        angles = 2.0 * np.arcsin(np.minimum(1.0, 0.5 * np.linalg.norm(
            ways[:, other] - ways[:, one], axis=2)))  # fmt: skip
        lengths = 0.5 * (body.lengths[one] + body.lengths[other])
        folded = (0.5 * stiffness[one] * angles**2 / lengths).sum(axis=1)
    lines = body.parts[body.ends[:, 0]]
    chords = np.zeros_like(ways)
    for line in np.unique(lines):
        own = lines == line
        mean = np.einsum("ked,e->kd", ways[:, own], body.lengths[own])
        chords[:, own] = (mean / np.linalg.norm(mean, axis=1)[:, None])[:, None]
    square = 2.0 - 2.0 * np.einsum("ked,ked->ke", ways, chords)  # of small angles
    pull = np.maximum(run.section_force(body).N, 0.0)
    return folded, (0.5 * pull * square * body.lengths).sum(axis=1)


def _inertia(scene: Scene, run: Trajectory, quantity: Quantity) -> float:
    """Return what inertia and the vibration that it starts change of a quasi-static motion."""
    dt = float(np.diff(run.t).min())
    rates = np.diff(quantity.history(run), axis=0) / np.diff(run.t)[:, None]
    with warnings.catch_warnings():  # their symmetric part is enough for an estimate
        warnings.simplefilter("ignore", ApproximateModes)
        omega = 2.0 * np.pi * float(modes(scene, 1, at=run.last).frequencies[0])
    if not omega > 0.0:
        return np.inf
    turns = float(np.linalg.norm(np.diff(rates, axis=0), axis=1).max())
    # A kink between saved times leaves a vibration of 1 / omega of the change of the rate.
    return turns * max(2.0 / (omega**2 * dt), 1.0 / omega) + float(np.linalg.norm(rates[0])) / omega


def flexibility(run: Trajectory, quantity: Position) -> float:
    """Estimate by how much the position of a point of a beam would change if the beam were rigid.

    Parameters
    ----------
    run : Trajectory
        A motion of the beam with elements.
    quantity : Position
        Of a point of that beam.

    Returns
    -------
    float
        Largest distance over time of the point from where the rigid motion has it that is closest
        to the nodes of the beam [m].
    """
    body = quantity.point.beam
    r = np.stack([run.position(body.node(i)) for i in range(body.n_nodes)], axis=1)
    weights = np.zeros(body.n_nodes)
    np.add.at(weights, _edges(body), 0.5 * body.lengths[:, None] / body.lengths.sum())
    middle, here = weights @ body.positions, np.einsum("n,knd->kd", weights, r)
    rest, apart = body.positions - middle, r - here[:, None]
    # The rotation that brings the reference shape next to the nodes (Kabsch 1976).
    left, _, right = np.linalg.svd(np.einsum("n,ni,knj->kij", weights, rest, apart))
    signs = np.ones((len(r), body.dim))
    signs[:, -1] = np.sign(np.linalg.det(left) * np.linalg.det(right))
    turned = np.einsum("i,kij,kj,kjl->kl", quantity.point.position - middle, left, signs, right)
    return float(np.linalg.norm(run.position(quantity.point) - here - turned, axis=1).max())
