"""Contact of beams with each other: forces, energy, momentum and search against formulas."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from tests.matrices import full, stiffness

STIFFNESS, RADIUS = 1e6, 0.005
SECTION, MATERIAL = ancf.Circle(2.0 * RADIUS), ancf.Material(1e8, 1e3)
REACH = 2.0 * RADIUS
AWAY = np.array([0.0, 0.0, 9.0])


def crossed(angle, depth, shift=(0.0, 0.0, 0.0), n=6, element="thin"):
    """Two straight cables of elements of 20 radii that cross, with a penetration."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    along = np.array([math.cos(angle), math.sin(angle), 0.0])
    half = 0.5 * n * 20.0 * RADIUS
    middle, up = np.array(shift), np.array([0.0, 0.0, REACH - depth])
    lower = scene.add_beam(element, (-half, 0, 0), (half, 0, 0), n, SECTION, MATERIAL)
    ends = (middle + up - 1.1 * half * along, middle + up + 1.1 * half * along)
    upper = scene.add_beam(element, *ends, n, SECTION, MATERIAL)
    return scene, scene.contact(lower, upper, stiffness=STIFFNESS)


def system_of(made, above=0.0):
    """The system of a scene, made with the second body further up, and its start where asked."""
    scene, _ = made
    system = System(scene)
    part = next(each for each in system.contributions if hasattr(each, "contact"))
    q = system.q0.copy()
    for places in system.vectors("r")[1:]:
        q[places[:, 2]] -= above
    return system, part, q


def lowered(angle, depth, **more):
    """A system of crossed cables with any penetration, which a scene would refuse at the start."""
    return system_of(crossed(angle, -RADIUS, **more), above=RADIUS + depth)


def bent(depth, rng, size=3e-3, **more):
    """The same with all coordinates moved at random."""
    system, part, q = lowered(0.7, depth, **more)
    return system, part, q + size * rng.normal(size=system.n_all)


def forces_at_rest(part, q):
    """Resultant, sums of normal forces and of friction, and penetration in a state."""
    return [each[0] for each in part.forces(q[None], np.zeros((1, len(q))))]


def residual(system, q):
    rest, none = np.zeros(system.n_all), np.zeros(0)
    return system.assembly.residual(q, rest, rest, none, rest, none)[0]


def between(system, q0, q1):
    rest, none = np.zeros(system.n_all), np.zeros(0)
    return system.assembly.residual_between(q0, q1, rest, rest, none, rest, none)[0]


def rotations(system, q):
    """Velocities of all coordinates under rotations about the three axes, (3, n_all)."""
    out = np.zeros((3, system.n_all))
    for name in ("r", "r_x"):
        for places in system.vectors(name):
            for axis in range(3):
                out[axis][places] = np.cross(np.eye(3)[axis], q[places])
    return out


@pytest.mark.parametrize("angle", [math.pi / 2, 0.3])
def test_a_crossing_has_the_force_of_the_overlap_of_two_parabolas(angle):
    """(4/3) sqrt(2) k e^1.5 / sqrt(c), with the curvature c = sin^2 a / d of the gap."""
    depth = 0.1 * RADIUS
    _, part, q = lowered(angle, depth)
    force, size, _, deepest = forces_at_rest(part, q)
    curvature = math.sin(angle) ** 2 / (REACH - depth)
    expected = 4.0 / 3.0 * math.sqrt(2.0) * STIFFNESS * depth**1.5 / math.sqrt(curvature)
    assert np.allclose(force, (0.0, 0.0, -expected), rtol=5e-3, atol=1e-9 * expected)
    assert size == pytest.approx(expected, rel=1e-2)  # some are at an angle to the resultant
    # The largest is at a Gauss point, just beside the crossing or on it.
    assert deepest == pytest.approx(depth, rel=5e-3)


@pytest.mark.parametrize("angle", [math.pi / 2, 0.3, 0.05, 0.0])
def test_a_crossing_that_slides_along_elements_has_no_ripple(angle):
    forces = []
    for x in np.linspace(-0.5, 0.5, 41):
        shift = (20.0 * RADIUS * x, 0.13 * RADIUS, 0.0)
        _, part, q = lowered(angle, 0.1 * RADIUS, shift=shift, n=20)
        forces.append(forces_at_rest(part, q)[0][2])
    forces = np.array(forces)
    assert np.ptp(forces) < 1e-6 * np.abs(forces).mean()


def test_parallel_cables_press_with_the_stiffness_times_the_penetration():
    _, part, q = lowered(0.0, 0.02 * RADIUS)
    length = 6 * 20.0 * RADIUS  # and a little beyond its ends, where they are half spheres
    force = forces_at_rest(part, q)[0]
    assert -force[2] == pytest.approx(STIFFNESS * 0.02 * RADIUS * length, rel=4e-3)


@pytest.mark.parametrize("element", ["thin", "string"])
def test_forces_are_derivatives_of_the_energy(element, rng):
    system, part, q = bent(0.3 * RADIUS, rng, 1e-3, element=element)
    assert len(part.compiled.touches(q)[0])
    h, units = 1e-8, np.eye(system.n_all)

    def energy(q):
        return system.assembly.strain_energy(q)

    differences = np.array([(energy(q + h * e) - energy(q - h * e)) / (2 * h) for e in units])
    assert np.abs(residual(system, q) - differences).max() < 1e-5 * np.abs(differences).max()


def wrapped(depth, n=24, spread=0.0, material=MATERIAL, stiffness=STIFFNESS):
    """Half a turn of a rope around a bar, whose axis is the centre of its curvature."""
    scene, bar = ancf.Scene((0.0, 0.0, 0.0)), 4.0 * RADIUS
    reach, along = RADIUS + bar - depth, 4.0 * RADIUS
    lower = scene.add_beam("thin", (-along, 0, 0), (along, 0, 0), 3, ancf.Circle(2 * bar), MATERIAL)

    def axis(s):
        turned = math.pi * np.asarray(s)
        y, z = reach * np.array([-np.cos(turned), np.sin(turned)])
        return np.stack([spread * turned, y, z], axis=-1)

    rope = scene.add_beam(
        "thin", curve=axis, rest="straight", n_elements=n, section=SECTION, material=material
    )
    contact = scene.contact(lower, rope, stiffness=stiffness)
    return scene, contact, reach


@pytest.mark.parametrize("spread", [0.0, 2e-3])
def test_a_rope_around_a_bar_presses_with_the_stiffness_times_the_penetration(spread):
    """Points of the bar's axis have no unique foot on the rope; points of the rope have one."""
    depth = 0.04 * RADIUS
    scene, _, reach = wrapped(depth, spread=spread)
    _, part, q = system_of((scene, None))
    force, size, *_ = forces_at_rest(part, q)
    length = math.pi * math.hypot(reach, spread)
    assert size == pytest.approx(STIFFNESS * depth * length, rel=0.01)
    # Along half a circle the resultant is 2/pi of the sum.
    assert -force[2] == pytest.approx(size * 2.0 / math.pi, rel=0.02)


def test_forces_of_a_rope_around_a_bar_change_with_its_motion_continuously(rng):
    """A small motion changes them by little; before, points of the bar chose other feet."""
    scene, *_ = wrapped(0.04 * RADIUS)
    system, part, q = system_of((scene, None))
    assert len(part.compiled.touches(q)[0])
    first = residual(system, q)
    for _ in range(20):
        moved = residual(system, q + 1e-11 * rng.normal(size=system.n_all))
        assert np.abs(moved - first).max() < 1e-4 * np.abs(first).max()


def test_a_rope_on_a_bar_has_the_pressure_of_its_tension():
    """T / R in the middle, and an equilibrium of steps that all converge."""
    soft, tension = ancf.Material(2e6, 1e3, axial_damping=5e-3), 20.0
    scene, contact, reach = wrapped(0.0, 32, material=soft, stiffness=1e8)
    bar, rope = contact.bodies
    for end in (bar.start, bar.end):
        scene.clamp(end)
    for end in (rope.start, rope.end):
        tail = np.array(end.position) - (0.0, 0.0, 0.1)
        part = scene.add_beam("thin", end.position, tail, 12, SECTION, soft)
        scene.connect(part.start, end)
        scene.add_mass(part.end, 0.1)
        scene.point_force(part.end, (0.0, 0.0, -tension))
    run = ancf.simulate(scene, 0.3, 1e-3, integrator=ancf.GeneralizedAlpha(0.0))
    assert run.stats.iterations < 8 * run.stats.steps
    inside = tension - math.pi * soft.youngs_modulus * RADIUS**4 / (8.0 * reach**2)  # by bending
    stretch = 1.0 + run.strain(rope)[-1, 15:17].mean()
    pressure = run.contact_force(rope).pressure[-1, 14:18]
    assert pressure == pytest.approx(4 * [inside * stretch / reach], rel=0.02)


def test_forces_of_contact_have_neither_resultant_nor_moment(rng):
    system, part, q = bent(0.3 * RADIUS, rng, 1e-3)
    size = forces_at_rest(part, q)[1]
    r = residual(system, q)
    for direction in range(3):
        assert abs(r @ system.uniform(direction)) < 1e-12 * size
    assert np.abs(rotations(system, q) @ r).max() < 1e-12 * size
    q1 = q + 1e-3 * rng.normal(size=system.n_all)
    r = between(system, q, q1)
    for direction in range(3):
        assert abs(r @ system.uniform(direction)) < 1e-12 * np.abs(r).sum()
    assert np.abs(rotations(system, 0.5 * (q + q1)) @ r).max() < 1e-12 * np.abs(r).sum()


def test_between_two_states_the_forces_do_the_work_of_the_energy(rng):
    system, _, q0 = bent(0.3 * RADIUS, rng, 1e-3)
    energy = system.assembly.strain_energy
    for size in (3e-3, 1e-4, 1e-6, 1e-8, 0.0):
        q1 = q0 + size * rng.normal(size=system.n_all)
        gained = energy(q1) - energy(q0)
        work = between(system, q0, q1) @ (q1 - q0)
        assert work == pytest.approx(gained, rel=1e-9, abs=1e-13 * energy(q0))


def test_an_impact_and_a_slide_within_one_step_do_the_work_of_the_energy():
    system, _, far = lowered(0.7, -0.5 * RADIUS)
    _, _, near = lowered(0.7, 0.3 * RADIUS)
    _, _, aside = lowered(0.7, 0.1 * RADIUS, shift=(3.0 * RADIUS, 2.0 * RADIUS, 0.0))
    energy = system.assembly.strain_energy
    for q0, q1 in ((far, near), (near, far), (near, aside), (aside, near), (far, aside)):
        r = between(system, q0, q1)
        assert r @ (q1 - q0) == pytest.approx(energy(q1) - energy(q0), rel=1e-9)


def test_the_matrix_has_the_stiffness_of_each_body_by_itself():
    system, _, q = lowered(0.7, 0.1 * RADIUS)
    n, none = system.n_free, np.zeros(0)
    lower = system.vectors("r")[0]
    up = np.zeros(system.n_all)
    up[lower[:, 2]] = 1.0
    h = 1e-9

    def force(q):
        return up @ residual(system, q)

    expected = (force(q + h * up) - force(q - h * up)) / (2 * h)
    found = up[:n] @ full(system, system.assembly.matrix(0.0, 1.0, q, none, none)) @ up[:n]
    # Without the stress in the normals, which is smaller by the penetration over the distance.
    assert found == pytest.approx(expected, rel=0.02)


def test_the_matrix_of_a_step_that_enters_has_the_stiffness_of_its_mean_force():
    system, _, q0 = lowered(0.7, -0.2 * RADIUS)
    n, none = system.n_free, np.zeros(0)
    up = np.zeros(system.n_all)
    up[system.vectors("r")[1][:, 2]] = 1.0
    q1, h = q0 - 0.5 * RADIUS * up, 1e-7
    change = up @ (between(system, q0, q1 + h * up) - between(system, q0, q1 - h * up)) / (2 * h)
    between(system, q0, q1)
    matrix = full(system, system.assembly.matrix(0.0, 1.0, 0.5 * (q0 + q1), none, none))
    assert change > 1.0
    assert 0.5 * up[:n] @ matrix @ up[:n] == pytest.approx(change, rel=0.5)


@pytest.mark.parametrize("n", [3, 40, 200])
def test_the_search_finds_all_pairs(n, rng):
    scene = ancf.Scene((0.0, 0.0, 0.0))
    edges, places = [], []
    for k in range(n):
        start = rng.uniform(0.0, 0.1 * n ** (1 / 3), 3) + (k < n // 2) * AWAY
        places += [start, start + rng.normal(size=3) * rng.choice([0.01, 0.05])]
        edges.append((2 * k, 2 * k + 1))
    half = n // 2
    one = scene.add_mesh(places[: 2 * half], edges[:half], "thin", SECTION, MATERIAL)
    other = scene.add_mesh(places[2 * half :], edges[: n - half], "thin", SECTION, MATERIAL)
    scene.contact(one, other, stiffness=STIFFNESS)
    system = System(scene)
    part = next(each for each in system.contributions if hasattr(each, "contact"))
    together = system.q0.copy()
    together[system.vectors("r")[0]] -= AWAY
    for size in (0.0, 1e-3, 0.02):  # within the skin, and beyond it
        q = together + size * rng.normal(size=system.n_all)
        points = control_points(system, q)
        low, high = points.min(axis=1), points.max(axis=1)
        apart = (low[:, None] > high[None] + REACH) | (low[None] > high[:, None] + REACH)
        wanted = {(i, j) for i, j in np.argwhere(~apart.any(axis=2)) if i < half <= j}
        found = {tuple(sorted(pair)) for pair in part.compiled.pairs(q).tolist()}
        assert len(found) == len(part.compiled.pairs(q))
        assert wanted <= found


def control_points(system, q):
    """Control points of all elements, (n, 4, 3)."""
    out = []
    for body, r, r_x in zip(system.bodies, system.vectors("r"), system.vectors("r_x"), strict=True):
        third = body.lengths[:, None] / 3.0
        a, b = body.ends.T
        out.append([q[r[a]], q[r[a]] + third * q[r_x[a]], q[r[b]] - third * q[r_x[b]], q[r[b]]])
    return np.concatenate(out, axis=1).transpose(1, 0, 2)


def test_the_list_of_pairs_is_renewed_when_something_has_moved_by_the_skin():
    system, part, q = lowered(0.7, 0.1 * RADIUS)
    part.compiled.pairs(q)
    before = part.compiled.renewals
    part.compiled.pairs(q + 0.5 * REACH * system.uniform(0))
    assert part.compiled.renewals == before
    part.compiled.pairs(q + 2.5 * REACH * system.uniform(0))
    assert part.compiled.renewals == before + 1


def test_steps_in_which_axes_pass_through_each_other_are_refused():
    system, part, q = lowered(0.7, 0.1 * RADIUS)
    up = np.zeros(system.n_all)
    up[system.vectors("r")[1][:, 2]] = 1.0
    along = np.zeros(system.n_all)
    along[system.vectors("r")[1][:, 0]] = 1.0
    admits = part.compiled.admits
    assert admits(q, q)
    assert admits(q, q - RADIUS * up)
    assert not admits(q, q - 2.5 * RADIUS * up)
    assert not admits(q, q - 100.0 * RADIUS * up)
    assert not admits(q + 50.0 * RADIUS * up, q - 50.0 * RADIUS * up)
    assert admits(q, q + 50.0 * RADIUS * up)
    # However far they slide, or move together.
    assert admits(q, q + 50.0 * RADIUS * along)
    assert admits(q, q + 1e3 * RADIUS * system.uniform(2))


def test_forces_at_states_that_are_not_finite_are_none_that_a_step_accepts():
    system, _, q = lowered(0.7, 0.1 * RADIUS)
    bad = q.copy()
    bad[0] = np.nan
    assert np.isnan(residual(system, bad)).any()
    assert np.isnan(residual(system, 1e300 * q)).any()
    assert np.isfinite(residual(system, q)).all()


@pytest.mark.parametrize("element", ["thin", "string"])
@pytest.mark.parametrize("angle", [0.0, 0.3, 1.5])
def test_the_stiffness_between_beams_is_the_derivative_of_their_forces(angle, element, rng):
    system, _, q = lowered(angle, 0.1 * RADIUS, element=element)
    check_stiffness(system, q + 1e-4 * rng.normal(size=system.n_all), 1e-6)


@pytest.mark.parametrize("aside", [0.0, 2e-6, 1e-3])
def test_the_stiffness_is_the_derivative_where_cables_cross_at_nodes_of_both(aside):
    """Before, the normals of all points turned with a foot that was kept at the node."""
    system, _, q = lowered(math.pi / 2, 0.1 * RADIUS, shift=(aside * RADIUS, 0.0, 0.0))
    check_stiffness(system, q, 1e-6)


@pytest.mark.parametrize("element", ["thin", "string"])
@pytest.mark.parametrize("angle", [0.3, 1.5])
def test_the_stiffness_is_the_derivative_at_a_free_end(angle, element, rng):
    """Points beyond it have their feet there, which do not slide."""
    beyond = (60.0 * RADIUS + 0.5 * RADIUS, 2.0 * RADIUS, 0.0)
    system, _, q = lowered(angle, 0.3 * RADIUS, shift=beyond, element=element)
    check_stiffness(system, q + 1e-5 * rng.normal(size=system.n_all), 1e-4)


def check_stiffness(system, q, tolerance):
    """Compare the matrix and the stiffness between elements with differences of the forces."""
    h, n = 1e-8, system.n_free
    exact = np.empty((n, n))
    for k in range(n):
        move = h * np.eye(system.n_all)[k]
        exact[:, k] = (residual(system, q + move) - residual(system, q - move))[:n] / (2.0 * h)
    without = stiffness(system, q).toarray()
    size = np.abs(exact - without).max()
    between = system.coupling_stiffness(q).toarray()
    np.testing.assert_allclose(between, between.T, atol=1e-12 * size)
    np.testing.assert_allclose(without + between, exact, atol=tolerance * size)


def test_only_bodies_that_touch_are_coupled():
    system, part, apart = lowered(0.7, -0.1 * RADIUS)
    _, _, touching = lowered(0.7, 0.1 * RADIUS)
    assert system.coupling_stiffness(apart) is None
    up = np.zeros(len(touching))
    up[system.vectors("r")[1][:, 2]] = 1.0
    assert part.resisted_motions(apart) is None
    normals = part.resisted_motions(touching)
    assert np.all(normals @ up > 0.9)  # at points of the lower cable, and of the upper one


@pytest.mark.parametrize("angle", [math.pi / 2, 1.0, 0.3])
def test_no_overlap_is_missed_wherever_cables_cross(angle, rng):
    """Down to depths of 1e-6 radii, whose overlaps are a ten-thousandth of an element."""
    for _ in range(100):
        depth = RADIUS * 10.0 ** rng.uniform(-6.0, -1.0)
        shift = (*(20.0 * RADIUS * rng.uniform(-1.0, 1.0, 2)), 0.0)
        _, part, q = lowered(angle, depth, shift=shift, n=8)
        expected = 4.0 / 3.0 * math.sqrt(2.0 * REACH) * STIFFNESS * depth**1.5 / math.sin(angle)
        force = forces_at_rest(part, q)[0]
        assert -force[2] == pytest.approx(expected, rel=0.06)
