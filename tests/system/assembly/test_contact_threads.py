"""Contact divided among threads: the same sums, and between beams the same bits."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from tests.grids import level_grid

ROPE, WIRE = ancf.Circle(0.01), ancf.Material(1e8, 1e3)
FLOOR = ancf.HalfSpace((0, 0, 0), (0, 0, 1))
LAWS = {
    "none": {},
    "bristles": {"friction": 0.3, "static_friction": 0.4},
    "slip speed": {"friction": 0.3, "slip_speed": 1e-2},
    "restitution": {"restitution": 0.5},
}


def cable_on_floor(law):
    scene = ancf.Scene((0, 0, -9.81))
    cable = scene.add_beam("thin", (0, 0, 0.00495), (4, 0, 0.00495), 201, ROPE, WIRE)
    scene.pin(cable.start)
    string = scene.add_beam("string", (0, 1, 0.00495), (4, 1, 0.00495), 90, ROPE, WIRE)
    scene.contact([cable, string], FLOOR, stiffness=1e6, **law)
    return scene


def net_on_ball(law):
    nodes, edges, _ = level_grid(17, 0.2)
    scene = ancf.Scene((0, 0, -9.81))
    net = scene.add_mesh(nodes, edges, "thin", ancf.Circle(0.004), WIRE)
    scene.contact(net, ancf.Ball((0.1, 0.1, -1.0), 0.9985), stiffness=1e6, **law)
    return scene


def pile(law):
    rng = np.random.default_rng(1)
    scene = ancf.Scene((0, 0, -9.81))
    for k in range(20):
        angle = rng.uniform(0, np.pi)
        along = 0.1 * np.array([np.cos(angle), np.sin(angle), 0.0])
        middle = np.array([*rng.uniform(-0.02, 0.02, 2), 0.00985 * k])
        scene.add_beam("thin", middle - along, middle + along, 4, ROPE, WIRE)
    scene.contact(scene.beams, scene.beams, stiffness=1e6, **law)
    return scene


def divided(scene, threads):
    """A system whose contacts are divided, and its elements are not."""
    system = System(scene)
    parts = [each for each in system.contributions if hasattr(each, "contact")]
    if threads > 1:
        for part in parts:
            assert part.divide(system.n_free, system.n_all, threads)
    return system, parts


def results(system, _):
    """What contact adds in and after a step, the same motion for all systems."""
    rng = np.random.default_rng(20240704)
    q0 = system.q0 + 1e-5 * rng.normal(size=system.n_all)
    v = rng.normal(size=system.n_all)
    q1, none, rest = q0 + 1e-4 * v, np.zeros(0), np.zeros(system.n_all)
    assembly = system.assembly
    assembly.begin(q0)
    assembly.set_step(1e-4)
    end = q1, v, rest, none, rest, none
    middle = 0.5 * (q0 + q1)
    found = [
        assembly.residual(*end)[0],
        assembly.matrix(0.0, 1.0, q1, none, none, damping_factor=1e-3, v=v),
        assembly.material(0.0, 1.0, q1),
        assembly.residual_between(q0, *end)[0],
        assembly.matrix(0.0, 1.0, middle, none, none, damping_factor=1e-3, v=v),
        np.array([assembly.strain_energy(q1)]),
    ]
    assembly.residual(*end)
    assembly.accept(q1)
    return [*found, assembly.memory, assembly.history]


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("scene", [cable_on_floor, net_on_ball])
@pytest.mark.parametrize("threads", [2, 3])
def test_contact_with_obstacles_has_the_same_sums(scene, law, threads):
    alone, one, other = (results(*divided(scene(law), each)) for each in (1, threads, threads))
    for of_one, of_some, again in zip(alone, one, other, strict=True):
        assert np.abs(of_one - of_some).max(initial=0.0) <= 1e-13 * np.abs(of_one).max(initial=0.0)
        np.testing.assert_array_equal(of_some, again)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("threads", [2, 7])
def test_contact_between_beams_has_the_same_bits(law, threads):
    systems = [divided(pile(law), each) for each in (1, threads)]
    for of_one, of_some in zip(*(results(*each) for each in systems), strict=True):
        np.testing.assert_array_equal(of_one, of_some)
    q = systems[0][0].q0
    alone, some = (parts[0].compiled for _, parts in systems)
    for one, other in zip(alone.touches(q), some.touches(q), strict=True):
        np.testing.assert_array_equal(one, other)
    assert len(alone.touches(q)[0]) > 100
    # Every cable moves to the place of another one, or all move together.
    mixed = q.reshape(20, -1)[::-1].ravel().copy()
    for far, admitted in ((mixed, False), (q + 0.1, True)):
        assert alone.admits(q, far) == some.admits(q, far) == admitted


def test_an_obstacle_on_a_body_is_not_divided():
    """All its points push the body."""
    scene = ancf.Scene((0, 0, -9.81))
    cable = scene.add_beam("thin", (-1, 0, 0.105), (1, 0, 0.105), 40, ROPE, WIRE)
    pulley = scene.add_body(position=(0, 0, 0), mass=1.0, inertia=(1e-2, 1e-2, 1e-2))
    scene.contact(cable, ancf.Ball((0, 0, 0), 0.1), on=pulley, stiffness=1e6)
    system = System(scene)
    part = next(each for each in system.contributions if hasattr(each, "contact"))
    assert not part.divide(system.n_free, system.n_all, 2)


def test_a_run_on_two_threads_has_the_same_counts():
    runs = []
    for threads in (1, 2):
        scene = ancf.Scene((0, 0, -9.81))
        cable = scene.add_beam("thin", (0, 0, 0.005), (56, 0, 0.005), 2800, ROPE, WIRE)
        scene.contact(cable, FLOOR, stiffness=1e6, friction=0.3)
        runs.append(ancf.simulate(scene, 5e-3, 5e-4, threads=threads))
    one, two = (run.stats for run in runs)
    assert (one.threads, two.threads) == (1, 2)
    assert (one.steps, one.iterations) == (two.steps, two.iterations)
    assert np.abs(runs[0].q - runs[1].q).max() < 1e-12
