"""Bristles between beams: forces of a step, momentum, rotation, and overlaps that move."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.scene.force_elements.contacts import GRIP_RATIO
from ancfsparse.system.contributions.force_elements.contact_losses import N_LOSSES
from tests.matrices import full
from tests.system.contributions.test_beam_contacts import (
    MATERIAL,
    RADIUS,
    REACH,
    SECTION,
    STIFFNESS,
    between,
    residual,
    system_of,
)

FRICTION, STEP = 0.3, 1e-9  # in which impacts are not damped
DEPTH = 0.1 * RADIUS


def crossed(friction=FRICTION, element="thin", place=0.05):
    """A system of two cables that cross with a penetration of a tenth, and its state."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    lower = scene.add_beam(element, (-0.3, 0, 0), (0.3, 0, 0), 6, SECTION, MATERIAL)
    along = np.array([math.cos(1.2), math.sin(1.2), 0.0])
    middle = np.array([place, 0.0, REACH + RADIUS])
    ends = middle - 0.35 * along, middle + 0.25 * along
    upper = scene.add_beam(element, *ends, 6, SECTION, MATERIAL)
    made = scene, scene.contact(lower, upper, stiffness=STIFFNESS, friction=friction)
    system, part, q = system_of(made, above=RADIUS + DEPTH)
    rest_at(system, q)
    return system, part, q


def rest_at(system, q):
    """Begin without deflections in a state."""
    system.assembly.memory = 0.0 * system.assembly.memory
    system.assembly.set_step(0.0)
    system.assembly.accept(q)


def moved(system, q, shift):
    """The same state with the second body displaced."""
    out = q.copy()
    out[system.vectors("r")[1]] += shift
    return out


def take_step(system, q0, q1, is_mean=False):
    """Residual of a step to q1, which is then accepted."""
    system.assembly.set_step(STEP)
    r = between(system, q0, q1) if is_mean else residual(system, q1)
    system.assembly.accept(q1)
    return r


def bristles_of(system):
    """Code, stiffness and force of all bristles of the last accepted state, (k, 5)."""
    slots = system.assembly.history[:-N_LOSSES].reshape(-1, 5)
    return slots[slots[:, 0] > 0.0]


def friction_on_upper(system, part, q):
    """Resultant of friction on the second body."""
    history = system.assembly.history
    elements, *_ = part.compiled.touches(q)
    friction = part.friction(q, np.zeros(len(q)), history)
    on_upper = (elements >= 6).astype(float)
    return (on_upper[:, 0] - on_upper[:, 1]) @ friction


@pytest.mark.parametrize("element", ["thin", "string"])
def test_friction_is_the_stiffness_times_the_way_up_to_mu_times_the_normal_force(element):
    """K is a tenth of that of all Gauss points: the mean length of the overlaps of both axes."""
    system, part, q = crossed(element=element)
    length = 2.0 * math.sqrt(2.0 * DEPTH * (REACH - DEPTH)) / math.sin(1.2)
    way = np.array([0.3e-5, 0.4e-5, 0.0])
    take_step(system, q, moved(system, q, way))
    (bristle,) = bristles_of(system)
    assert bristle[1] == pytest.approx(GRIP_RATIO * STIFFNESS * length, rel=0.02)
    np.testing.assert_allclose(bristle[2:], bristle[1] * -way, rtol=1e-9, atol=1e-12)
    here = moved(system, q, way)
    found = friction_on_upper(system, part, here)
    np.testing.assert_allclose(found, -bristle[1] * way, rtol=1e-9, atol=1e-12)
    _, size, friction, _ = (
        each[0] for each in part.forces(here[None], 0 * here[None], system.assembly.history[None])
    )
    assert friction == pytest.approx(5e-6 * bristle[1], rel=1e-9)
    take_step(system, here, moved(system, q, 1e3 * way))
    (bristle,) = bristles_of(system)
    assert np.linalg.norm(bristle[2:]) == pytest.approx(FRICTION * size, rel=0.02)
    np.testing.assert_allclose(bristle[2:4] / np.linalg.norm(bristle[2:]), [-0.6, -0.8], atol=1e-3)


@pytest.mark.parametrize("is_mean", [False, True], ids=["end", "mean"])
def test_bristles_keep_momentum_and_do_the_work_of_their_energy(rng, is_mean):
    system, _, q = crossed()
    q0 = q + 1e-4 * rng.normal(size=len(q))
    rest_at(system, q0)
    without, _, _ = crossed(friction=0.0)
    stored, limit = 0.0, 0.0
    for _ in range(20):
        q1 = moved(system, q0, (*rng.normal(scale=1e-5, size=2), 0.0))
        r = take_step(system, q0, q1, is_mean)
        without.assembly.memory = 0.0 * without.assembly.memory
        f = r - (between(without, q0, q1) if is_mean else residual(without, q1))
        for direction in range(3):
            assert abs(f @ system.uniform(direction)) < 1e-12 * np.abs(f).sum()
        now = np.sum(bristles_of(system)[:, 2:] ** 2 / bristles_of(system)[:, 1:2]) / 2.0
        if is_mean:  # never more than was stored; the whole of it where it sticks
            assert f @ (q1 - q0) >= now - stored - 1e-12
        limit, stored = max(limit, now), now
        q0 = q1
    assert limit > 0.0


@pytest.mark.parametrize("is_mean", [False, True], ids=["end", "mean"])
def test_a_rotation_about_the_normal_turns_friction_and_changes_no_size(is_mean):
    system, _, q = crossed()
    q1 = moved(system, q, (0.5e-5, 0.2e-5, 0.0))
    take_step(system, q, q1, is_mean)
    last = q1
    (before,) = bristles_of(system)
    for k in range(1, 11):
        angle = 0.3 * k
        one, other = math.cos(angle), math.sin(angle)
        turn = np.array([[one, -other, 0.0], [other, one, 0.0], [0.0, 0.0, 1.0]])
        q2 = q1.copy()
        for name in ("r", "r_x"):
            for places in system.vectors(name):
                q2[places] = q1[places] @ turn.T
        take_step(system, last, q2, is_mean)
        last = q2
    (after,) = bristles_of(system)
    np.testing.assert_allclose(after[2:], turn @ before[2:], rtol=1e-9, atol=1e-15)


def test_friction_stays_where_an_overlap_passes_from_element_to_element():
    """A bristle that sticks is transferred in proportion, without a loss of force."""
    system, _, q = crossed(place=-0.02)
    take_step(system, q, moved(system, q, (1e-5, 0.0, 0.0)))
    force = bristles_of(system)[:, 2:].sum(axis=0)
    codes = {float(bristles_of(system)[0, 0])}
    here = moved(system, q, (1e-5, 0.0, 0.0))
    for _ in range(400):  # all that touches moves along the lower axis, as by rolling
        q1 = moved(system, here, (1e-4, 0.0, 0.0))
        system.assembly.set_step(0.0)  # bristles do not stretch
        system.assembly.accept(q1)
        here = q1
        now = bristles_of(system)
        codes |= set(now[:, 0].tolist())
        np.testing.assert_allclose(now[:, 2:4].sum(axis=0), force[:2], rtol=1e-2, atol=1e-4)
    assert len(codes) == 2


def test_an_overlap_that_breathes_keeps_its_force():
    """Where a pair that sticks would creep if the stiffness decreased with the overlap."""
    system, _, q = crossed()
    take_step(system, q, moved(system, q, (1e-5, 0.0, 0.0)))
    (before,) = bristles_of(system)
    system.assembly.set_step(STEP)
    for k in range(20):
        system.assembly.accept(moved(system, q, (1e-5, 0.0, 0.3 * DEPTH * math.sin(k))))
    (after,) = bristles_of(system)
    np.testing.assert_allclose(after[2:], before[2:], rtol=1e-12, atol=1e-14)
    assert after[1] > before[1]


@pytest.mark.parametrize(
    ("friction", "way"), [(0.3, 1e-5), (0.003, 1e-4)], ids=["sticks", "slides"]
)
@pytest.mark.parametrize("is_mean", [False, True], ids=["end", "mean"])
def test_the_matrix_has_the_derivative_of_friction_by_places_of_each_body(is_mean, friction, way):
    system, _, q = crossed(friction)
    without, _, _ = crossed(friction=0.0)
    q1 = moved(system, q, (0.6 * way, 0.8 * way, 0.0))
    n, none, rest = system.n_free, np.zeros(0), np.zeros(system.n_all)

    def forces(to):
        return [
            between(each, q, to) if is_mean else residual(each, to) for each in (system, without)
        ]

    for each in (system, without):
        rest_at(each, q)
        each.assembly.set_step(STEP)
    forces(q1)
    x = 0.5 * (q + q1) if is_mean else q1
    blocks = [
        full(each, each.assembly.matrix(0.0, 1.0, x, none, none, v=rest))[:n, :n]
        for each in (system, without)
    ]
    found = blocks[0] - blocks[1]
    scale = np.abs(found).max()
    assert scale > 0.0
    assert np.abs(found - found.T).max() < 1e-12 * scale
    own = np.concatenate([system.vectors(name)[1] for name in ("r", "r_x")])
    along = own[:, :2].ravel()  # the normal force, which limits friction, stays
    h, factor = 1e-8, 2.0 if is_mean else 1.0
    units = [np.eye(system.n_all)[i] for i in along[::3]]
    whole = [moved(system, 0.0 * q, np.eye(3)[c]) for c in range(2)]
    slides = friction < 0.1
    for unit in whole if slides else units + whole:
        one, other = (np.subtract(*forces(q1 + s * h * unit)) for s in (1.0, -1.0))
        expected = factor * (one - other) / (2.0 * h)
        error = expected[:n] - found @ unit[:n]
        # The matrix leaves out that forces move along the axes, and with them their shares.
        errors = [error @ each[:n] for each in whole] if slides else error[along]
        assert np.abs(errors).max() < (2e-4 if slides else 1e-3) * scale


def test_more_pairs_than_the_history_has_slots_for_are_an_error(monkeypatch):
    module = "ancfsparse.system.contributions.force_elements.beam_contact.beam_contacts"
    monkeypatch.setattr(f"{module}.SLOTS_PER_ELEMENT", 0)
    scene = ancf.Scene((0.0, 0.0, -9.81))
    rope = ancf.Circle(2.0 * RADIUS), MATERIAL
    lower = scene.add_beam("thin", (-0.3, 0, 0), (0.3, 0, 0), 40, *rope)
    upper = scene.add_beam("thin", (-0.307, 0, 0.0101), (0.307, 0, 0.0101), 41, *rope)
    scene.contact(lower, upper, stiffness=1e6, friction=0.3)
    for k in range(41):
        scene.clamp(lower.node(k))
    with pytest.raises(ancf.InputError, match="pairs of elements touch each other, and friction"):
        ancf.simulate(scene, 0.05, 1e-3)
