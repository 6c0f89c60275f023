"""Equilibria with contact: bodies do not pass through each other."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System

RADIUS = 0.005  # of the ropes [m]
WEIGHT = 2e3 * np.pi * RADIUS**2 * 9.81  # N/m


def obstacle_below(noun, top, x):
    """An obstacle with its highest point at (x, top)."""
    return {
        "ball": lambda: ancf.Ball((x, top - 0.1), 0.1),
        "drum": lambda: ancf.Drum((x, top - 0.06), 0.06),
        "capsule": lambda: ancf.Capsule((x - 0.2, top - 0.1), (x + 0.2, top - 0.1), 0.1),
        "block": lambda: ancf.Block((x, top - 0.1), (0.3, 0.2), radius=0.02),
    }[noun]()


def rope_above(noun, seed, load):
    """A straight rope, pinned at both ends above an obstacle, and its point above the middle."""
    rng = np.random.default_rng(seed)
    modulus, gap, x = (
        10.0 ** rng.uniform(5.0, 8.0),
        rng.uniform(0.002, 0.08),
        rng.uniform(-0.3, 0.3),
    )
    scene = ancf.Scene((0.0, 0.0))
    rope = scene.add_beam(
        "thin",
        (-1, 0),
        (1, 0),
        40,
        ancf.Circle(2.0 * RADIUS),
        ancf.Material(modulus, 2e3, rayleigh=(10.0, 0.0)),
    )
    scene.pin(rope.start)
    scene.pin(rope.end)
    scene.distributed_force(rope, load(np.array([0.0, -WEIGHT])))
    scene.contact(rope, obstacle_below(noun, -RADIUS - gap, x))
    return scene, rope.at(1.0 + x)


def rope_above_rope(seed, load, at_nodes=False):
    """A straight soft rope above a stiffer one, and the points of both where they cross.

    At nodes of both the soft one is softer.
    """
    rng = np.random.default_rng(seed)
    modulus, gap = 10.0 ** rng.uniform(5.0, 8.5), rng.uniform(0.001, 0.02)
    x, y, angle = rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2), rng.uniform(0.8, 2.3)
    if at_nodes:
        x, y, modulus = round(x, 1), round(y, 1), 1e5 * (modulus / 1e5) ** (2.0 / 7.0)
    along, z = np.array([np.cos(angle), np.sin(angle), 0.0]), 2.0 * RADIUS + gap
    scene, section = ancf.Scene((0.0, 0.0, 0.0)), ancf.Circle(2.0 * RADIUS)
    damped = {"rayleigh": (10.0, 0.0)}
    lower = scene.add_beam(
        "thin", (-1, 0, 0), (1, 0, 0), 20, section, ancf.Material(1e9, 2e3, **damped)
    )
    middle = np.array([x, 0.0, z]) + y * along
    upper = scene.add_beam(
        "thin", middle - along, middle + along, 20, section, ancf.Material(modulus, 2e3, **damped)
    )
    for body in (lower, upper):
        scene.pin(body.start)
        scene.pin(body.end)
        scene.distributed_force(body, load(np.array([0.0, 0.0, -WEIGHT])))
    scene.contact(lower, upper)
    return scene, lower.at(1.0 + x), upper.at(1.0 - y)


def find_equilibria(make):
    """Positions of points at rest by three methods, None without an equilibrium, and by a motion.

    `make` returns a scene and points for a function that makes a load of its value at the end.
    """

    def positions(solution, points):
        return np.array([np.atleast_2d(solution.position(point))[-1] for point in points])

    scene, *points = make(tuple)
    motion = ancf.simulate(scene, 6.0, 2e-3, integrator=ancf.GeneralizedAlpha(0.0))
    growing, *same = make(lambda load: ancf.Ramp(tuple(load), 1.0, smooth=True))
    found = []
    for solve, where in (
        (lambda: ancf.solve_static(scene), points),
        (lambda: ancf.load_path(scene, points=100), points),
        (lambda: ancf.quasi_static(growing, 1.0, 0.05), same),
    ):
        try:
            solution = solve()
        except ancf.EquilibriumError:
            continue
        if getattr(solution, "complete", True):
            found.append(positions(solution, where))
    return found, positions(motion, points)


@pytest.mark.filterwarnings("ignore::ancfsparse.PenetrationWarning")
@pytest.mark.parametrize("noun", ["ball", "drum", "capsule", "block"])
def test_ropes_do_not_pass_through_obstacles(noun):
    """They lie on them as after a motion.  Before, `solve_static` let all but one pass."""
    n_found = 0
    for seed in range(4):
        found, at_rest = find_equilibria(lambda load, seed=seed: rope_above(noun, seed, load))
        n_found += len(found)
        for positions in found:
            assert positions == pytest.approx(at_rest, abs=1e-4)
    assert n_found >= 11


@pytest.mark.filterwarnings("ignore::ancfsparse.PenetrationWarning")
@pytest.mark.parametrize(
    ("at_nodes", "least"), [(False, 14), pytest.param(True, 15, marks=pytest.mark.slow)]
)
def test_ropes_do_not_pass_through_ropes(at_nodes, least):
    """Before, `solve_static` let all of these pass; at nodes it refused half of them."""
    n_found = 0
    for seed in range(5):
        found, at_rest = find_equilibria(
            lambda load, seed=seed: rope_above_rope(seed, load, at_nodes)
        )
        n_found += len(found)
        for positions in found:
            assert positions == pytest.approx(at_rest, abs=1e-4)
    assert n_found >= least


@pytest.mark.filterwarnings("ignore::ancfsparse.PenetrationWarning")
@pytest.mark.parametrize(("seed", "at_nodes"), [(3, False), (8, True)])
def test_a_path_passes_the_touch_of_soft_ropes_in_short_steps(seed, at_nodes):
    """Before, its shortest step was one over its first tangent, of hundreds of metres."""
    scene, *points = rope_above_rope(seed, tuple, at_nodes)
    path = ancf.load_path(scene, points=150)
    assert path.complete
    rest = ancf.solve_static(scene)
    for point in points:
        assert path.position(point)[-1] == pytest.approx(rest.position(point), abs=1e-6)


@pytest.mark.filterwarnings("ignore::ancfsparse.PenetrationWarning")
@pytest.mark.parametrize("stiffness", [None, 1e6])
def test_a_cantilever_does_not_pass_through_cylinders(stiffness):
    """That of `cantilever_on_cylinders`, whose tip is at (1.890, -0.482) m with 256 elements."""
    for n in (24, 48, 128):
        scene, section = ancf.Scene((0.0, 0.0)), ancf.Rectangle(1e-3, 1e-3)
        rod = scene.add_beam("thin", (0, 0), (2, 0), n, section, ancf.Material(2.07e11, 7800.0))
        scene.clamp(rod.start)
        load = 80.0 * 7800.0 * section.area * 2.0 / 8
        for i in range(1, 9):
            scene.point_force(rod.at(0.25 * i), (0.0, -(0.5 if i == 8 else 1.0) * load))
        for centre, outer in (((1.5, -0.5), 0.2), ((0.5, -0.15), 0.1)):
            drum = ancf.Drum(centre, outer - 0.5e-3)
            scene.contact(rod, drum, stiffness=stiffness, radius=0.5e-3)
        tip = ancf.solve_static(scene).position(rod.end)
        assert tip == pytest.approx([1.890, -0.482], abs=4e-3)


def test_a_driven_end_does_not_pass_through_a_ball():
    scene = ancf.Scene((0.0, 0.0))
    rope = scene.add_beam("thin", (0, 0), (1, 0), 20, ancf.Circle(0.01), ancf.Material(1e6, 2e3))
    scene.clamp(rope.start)
    scene.drive(rope.end, (1.0, -0.5))
    scene.contact(rope, ancf.Ball((1.0, -0.2), 0.1), stiffness=1e6)
    with pytest.raises(ancf.EquilibriumError, match="pass through each other"):
        ancf.solve_static(scene)


def moved(system, shift):
    """Coordinates of the reference shape after a displacement."""
    q = system.q_ref.copy()
    for indices in system.vectors("r"):
        q[indices] += shift
    return q


@pytest.mark.parametrize(
    ("obstacle", "shift", "is_admitted"),
    [
        (ancf.Ball((0.0, -0.2), 0.1), (0.0, -0.09), True),
        (ancf.Ball((0.0, -0.2), 0.1), (0.0, -0.098), True),
        (ancf.Ball((0.0, -0.2), 0.1), (0.0, -0.101), False),
        (ancf.Ball((0.0, -0.2), 0.1), (0.0, -0.4), False),
        (ancf.Ball((0.0, -0.2), 0.1), (1.2, -0.4), False),
        (ancf.Ball((0.0, -0.2), 0.1), (2.0, -0.1), True),
        (ancf.Ball((0.0, -0.2), 0.1), (0.0, 3.0), True),
        (ancf.Block((0.0, -0.2), (0.4, 1e-4)), (0.0, -0.3), False),
        (ancf.Block((0.0, -0.2), (0.4, 1e-4)), (0.0, -0.198), True),
        (ancf.HalfSpace((0.0, -0.01), (0.0, 1.0)), (0.0, -0.3), True),
    ],
)
def test_a_motion_is_admitted_if_no_axis_enters_an_obstacle(obstacle, shift, is_admitted):
    """The rope is 1 m long; half-spaces have no other side."""
    scene = ancf.Scene((0.0, 0.0))
    rope = scene.add_beam(
        "thin", (-0.5, 0), (0.5, 0), 40, ancf.Circle(2.0 * RADIUS), ancf.Material(1e6, 2e3)
    )
    scene.contact(rope, obstacle, stiffness=1e6)
    system = System(scene)
    assert system.admits(system.q_ref, moved(system, shift)) is is_admitted
    assert system.admits(moved(system, shift), moved(system, shift))


def test_an_obstacle_on_a_body_does_not_pass_through_a_rope():
    """A bar at -45 degrees turns towards a rope on the axis x, across it, and away from it."""
    scene = ancf.Scene((0.0, 0.0))
    rope = scene.add_beam(
        "thin", (0.3, 0), (0.5, 0), 10, ancf.Circle(2.0 * RADIUS), ancf.Material(1e6, 2e3)
    )
    body = scene.add_body(mass=1.0, inertia=1.0, position=(0.0, 0.0))
    scene.contact(rope, ancf.Capsule((0.2, -0.2), (0.4, -0.4), 0.01), on=body, stiffness=1e6)
    system = System(scene)
    for angle, is_admitted in ((0.6, True), (1.2, False), (-1.2, True)):
        q = system.q_ref.copy()
        turned = [np.cos(angle), np.sin(angle), -np.sin(angle), np.cos(angle)]
        q[system.places[1][0, 2:]] = turned
        assert system.admits(system.q_ref, q) is is_admitted
