"""Contacts of several bodies: the sum of the contacts of each pair, with one search for all."""

from itertools import pairwise

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.scene.force_elements.beam_contacts import BeamContact
from ancfsparse.system import System

MATERIAL = ancf.Material(1e8, 1e3)
RADII = 0.004, 0.005, 0.006
LAWS = {
    "none": {},
    "bristles": {"friction": 0.3},
    "slip speed": {"friction": 0.3, "slip_speed": 1e-2},
    "static friction": {"friction": 0.3, "static_friction": 0.5},
    "restitution": {"restitution": 0.5},
}
FLOOR = ancf.HalfSpace((0, 0, 0), (0, 0, 1))


def pile(speed=0.0):
    """Three rods of different radii across each other, each pressed into the one below."""
    scene = ancf.Scene((0, 0, -9.81))
    height = 0.0
    for k, radius in enumerate(RADII):
        height += 0.99 * radius
        along = 0.1 * np.array([np.cos(0.8 * k), np.sin(0.8 * k), 0.0])
        up = np.array([0.0, 0.0, height])
        scene.add_beam(
            "thin", up - along, up + along, 4, ancf.Circle(2 * radius), MATERIAL,
            velocity=(speed * k, 0.0, -0.1 * speed),
        )  # fmt: skip
        height += 0.99 * radius
    return scene


def in_one(scene, law):
    contacts = [scene.contact(scene.beams, FLOOR, stiffness=1e5, **law)]
    return [*contacts, scene.contact(scene.beams, scene.beams, stiffness=1e6, **law)]


def in_pairs(scene, law):
    contacts = [scene.contact(body, FLOOR, stiffness=1e5, **law) for body in scene.beams]
    for k, body in enumerate(scene.beams):
        for other in scene.beams[k:]:
            contacts.append(scene.contact(body, other, stiffness=1e6, **law))
    return contacts


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_forces_are_those_of_the_pairs(law, rng):
    systems = []
    for make in (in_one, in_pairs):
        scene = pile()
        make(scene, law)
        systems.append(System(scene))
    one, pairs = systems
    assert len(one.contributions) < len(pairs.contributions)
    q0 = one.q0 + 1e-4 * rng.normal(size=one.n_all)
    v = rng.normal(size=one.n_all)
    q1, none, rest = q0 + 1e-4 * v, np.zeros(0), np.zeros(one.n_all)
    found = []
    for system in systems:
        system.assembly.accept(q0)
        system.assembly.set_step(1e-4)
        end = q1, v, rest, none, rest, none
        found.append([
            system.assembly.residual(*end)[0],
            system.assembly.residual_between(q0, *end)[0],
            np.array([system.assembly.strain_energy(q1)]),
        ])  # fmt: skip
    for of_one, of_pairs in zip(*found, strict=True):
        np.testing.assert_allclose(of_one, of_pairs, rtol=0, atol=1e-12 * np.abs(of_pairs).max())


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_run_is_that_of_the_pairs(law):
    runs = []
    for make in (in_one, in_pairs):
        scene = pile(speed=0.2)
        contacts = make(scene, law)
        dt = 2e-5 if "restitution" in law else 2e-4  # which impacts with a restitution need
        runs.append((ancf.simulate(scene, 100 * dt, dt, solver=ancf.Newton()), contacts))
    (one, (floor, among)), (pairs, others) = runs
    assert np.abs(one.q - pairs.q).max() < 1e-9
    assert np.abs(one.q[-1] - one.q[0]).max() > 1e-4
    # Of all on the floor, and sums over pairs; the last one does not reach the floor.
    resultant = sum(pairs.contact_force(each).force for each in others[:3])
    sizes = sum(pairs.contact_force(each).size for each in others[3:])
    assert np.abs(resultant).max() > 0.1
    assert sizes.max() > 0.1
    np.testing.assert_allclose(one.contact_force(floor).force, resultant, atol=1e-5)
    np.testing.assert_allclose(one.contact_force(among).size, sizes, atol=1e-4)
    np.testing.assert_array_equal(one.contact_force(among).force, 0.0)
    for part in ("contact", "friction"):
        np.testing.assert_allclose(
            getattr(one.energy, part), getattr(pairs.energy, part), atol=1e-9
        )


def test_the_force_of_one_side_is_the_sum_of_its_pairs():
    alone, together = pile(), pile()
    lower, middle, upper = alone.beams
    pairs = [alone.contact(middle, each, stiffness=1e6) for each in (lower, upper)]
    lower, middle, upper = together.beams
    handle = together.contact(middle, [lower, upper], stiffness=1e6)
    a, b = (ancf.simulate(scene, 5e-3, 2e-4) for scene in (alone, together))
    expected = sum(a.contact_force(each).force for each in pairs)
    found = b.contact_force(handle).force
    assert np.abs(found).max() > 0.1
    np.testing.assert_allclose(found, expected, atol=1e-6)
    # The lower and the upper one are on the same side and do not touch each other.
    bodies = {tuple(point.beam for point in touch.points) for touch in b.contacts(0.0)}
    assert bodies == {(middle, lower), (middle, upper)}


def heap(n=30):
    """Short cables across each other in the air that fall and rise at random."""
    rng = np.random.default_rng(7)
    scene = ancf.Scene((0, 0, -9.81))
    for k in range(n):
        angle = rng.uniform(0, np.pi)
        along = 0.02 * np.array([np.cos(angle), np.sin(angle), 0.0])
        middle = np.array([*rng.uniform(-0.01, 0.01, 2), 0.0025 + 0.0045 * k])
        scene.add_beam(
            "thin", middle - along, middle + along, 2, ancf.Circle(0.004), MATERIAL,
            velocity=(0.0, 0.0, rng.uniform(-0.2, 0.2)),
        )  # fmt: skip
    return scene


def test_thirty_cables_touch_each_other_and_the_floor():
    scene = heap()
    floor = scene.contact(scene.beams, FLOOR, stiffness=1e6, friction=0.3)
    among = scene.contact(scene.beams, scene.beams, stiffness=1e6, friction=0.3)
    run = ancf.simulate(scene, 0.1, 1e-3)
    touches = [touch for t in run.t[::5] for touch in run.contacts(t) if touch.contact is among]
    assert len({point.beam for touch in touches for point in touch.points}) > 15
    assert run.contact_force(among).penetration.max() < 0.002
    tables = [run.contacts(t) for t in run.t[::5]]
    stretches = [(touch, table) for table in tables for touch in table if touch.contact is floor]
    assert len({touch.points[0].beam for touch, _ in stretches}) > 1
    for touch, table in stretches:  # of one body each
        assert touch.points[0].beam is touch.points[1].beam
        assert f"half-space, from {touch.points[0]!r}" in repr(table)


def test_the_search_is_one_and_its_pairs_are_those_of_all_bodies():
    scene = heap()
    scene.contact(scene.beams, scene.beams, stiffness=1e6)
    system = System(scene)
    parts = [each for each in system.contributions if hasattr(each, "contact")]
    assert len(parts) == 1
    pairs = parts[0].compiled.pairs(system.q0)
    ends = np.concatenate([body.positions[body.row_nodes[body.ends]] for body in scene.beams])
    skin, reach = 0.004, 0.004  # a diameter, which the search puts around all boxes
    low, high = ends.min(axis=1) - skin, ends.max(axis=1) + skin
    apart = (low[:, None] > high[None] + reach) | (low[None] > high[:, None] + reach)
    own = np.arange(len(ends)) // 2
    near = np.argwhere(~apart.any(axis=2) & (own[:, None] < own[None]))
    assert sorted(map(sorted, pairs.tolist())) == near.tolist()
    assert len(near) > 100


def test_bodies_of_one_side_do_not_touch_each_other():
    scene = heap(6)
    scene.contact(scene.beams[:3], scene.beams[3:], stiffness=1e6)
    system = System(scene)
    part = next(each for each in system.contributions if hasattr(each, "contact"))
    body = part.compiled.pairs(system.q0) // 2
    assert len(body)
    assert np.all((body < 3).sum(axis=1) == 1)


def test_a_chain_of_cables_that_touch_all_hangs_as_without_contact():
    """Joints between bodies of one contact leave out the axes there."""
    runs = []
    for touches in (False, True):
        scene = ancf.Scene((0, 0, -9.81))
        places = [(0, 0, 0), (0.2, 0, 0), (0.3, 0.15, 0), (0.5, 0.15, 0)]
        for start, end in pairwise(places):
            scene.add_beam("thin", start, end, 8, ancf.Circle(0.01), MATERIAL)
        one, two, three = scene.beams
        scene.pin(one.start)
        scene.connect(one.end, two.start)
        scene.connect(three.start, two.end)
        if touches:
            scene.contact(scene.beams, scene.beams, stiffness=1e6)
            assert str(scene).count("leaves out") == 2
        runs.append(ancf.simulate(scene, 0.05, 1e-3))
    np.testing.assert_allclose(runs[1].q, runs[0].q, rtol=0, atol=1e-9)


def test_a_file_has_the_sides_and_one_body_is_no_list(tmp_path):
    scene = pile()
    lower, middle, upper = scene.beams
    scene.contact(scene.beams, FLOOR, stiffness=1e5, friction=0.1)
    scene.contact([lower, middle], [middle, upper], stiffness=1e6)
    scene.contact(lower, lower, stiffness=1e6)
    file = tmp_path / "scene.json"
    scene.save(file)
    again = ancf.Scene.load(file)
    assert again == scene
    handle = again.attachments[1]
    assert isinstance(handle, BeamContact)
    assert [[body.name for body in side] for side in (handle.one, handle.other)] == [
        ["beam 0", "beam 1"], ["beam 1", "beam 2"],
    ]  # fmt: skip
    assert handle.radii == RADII
    assert '"body": {"kind": "Body", "body": "beam 0"}' in " ".join(file.read_text().split())


@pytest.mark.parametrize(
    ("sides", "sentence"),
    [
        (lambda a, b, c: ([], a), "a list of them such as scene.beams, got \\[\\]"),
        (lambda a, b, c: (a, ()), "a list of them such as scene.beams, got \\(\\)"),
        (lambda a, b, c: ([a, b, a], c), "beam 0 twice: name each body once"),
        (lambda a, b, c: (a, [c, c]), "beam 2 twice: name each body once"),
        (lambda a, b, c: ([a, "b"], c), "a beam or a mesh of this scene, got 'b'"),
        (lambda a, b, c: ([a, c], [c, b]), "the contact of beam 0 with beam 1 was added before"),
        (lambda a, b, c: ([b, c], a), "the contact of beam 1 with beam 0 was added before"),
        (lambda a, b, c: ([b, c], [b, c]), "the contact of beam 2 with itself was added before"),
    ],
)
def test_wrong_sides_are_refused(sides, sentence):
    scene = pile()
    lower, middle, upper = scene.beams
    scene.contact(lower, middle, stiffness=1e6)
    scene.contact(upper, upper, stiffness=1e6)
    one, other = sides(lower, middle, upper)
    with pytest.raises(ancf.InputError, match=sentence):
        scene.contact(one, other, stiffness=1e6)


def test_an_obstacle_is_touched_once_by_each_body():
    scene = pile()
    scene.contact(scene.beams[1], FLOOR, stiffness=1e5)
    with pytest.raises(ancf.InputError, match="the contact of beam 1 with the half-space was"):
        scene.contact(scene.beams, FLOOR, stiffness=1e5)
