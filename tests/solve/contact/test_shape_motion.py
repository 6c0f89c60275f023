"""Motion on obstacles of every shape: energy, momenta, friction, and shapes that are equal."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from tests.solve.contact.test_moving_obstacles import momenta
from tests.system.contributions.shapes import ORIENTED, SHAPES, lowered

SECTION, MATERIAL = ancf.Circle(0.004), ancf.Material(1e9, 1e3)


def struck(obstacle, is_moving, **friction):
    """A free cable that an obstacle on a free body hits, or that falls on a fixed one."""
    obstacle = lowered(obstacle, 0.0021)
    dim, pad = obstacle.dim, (0.0,) * (obstacle.dim - 2)
    scene, body = ancf.Scene((0.0, 0.0, *pad)), None
    cable = scene.add_beam(
        "thin",
        (-0.3, 0, *pad),
        (0.3, 0, *pad),
        24,
        SECTION,
        MATERIAL,
        velocity=None if is_moving else (0.3, -1.0, *pad),
    )
    if is_moving:
        body = scene.add_body(
            mass=0.05,
            inertia=2e-5 if dim == 2 else (2e-5, 3e-5, 4e-5),
            position=(0.01, -0.08, *pad),
            velocity=(0.3, 1.0, *pad),
            angular_velocity=5.0 if dim == 2 else (3.0, 5.0, 5.0),
            orientation=0.4 if dim == 2 else (0.6, 0.8, 0, 0),
        )
    return scene, scene.contact(cable, obstacle, on=body, stiffness=1e5, **friction)


FRICTION = {
    "none": {},
    "bristles": {"friction": 0.4},
    "sliding": {"friction": 0.4, "slip_speed": 0.05},
}


@pytest.mark.filterwarnings("ignore:.*no force on a part of the axis:ancfsparse.PenetrationWarning")
@pytest.mark.parametrize("friction", FRICTION)
@pytest.mark.parametrize("is_moving", [False, True])
@pytest.mark.parametrize("name", ORIENTED)
def test_momenta_are_kept_and_energy_is_lost_to_friction_alone(name, is_moving, friction):
    scene, contact = struck(ORIENTED[name], is_moving, **FRICTION[friction])
    run = ancf.simulate(scene, 0.03, 2e-4, integrator=ancf.EnergyMomentum(), tolerance=1e-11)
    energy = run.energy
    largest = energy.kinetic.max()
    assert energy.contact.max() > 0.002 * largest
    assert run.contact_force(contact).pressure.any()
    assert not energy.work.any()
    total = energy.kinetic + energy.elastic + energy.contact + energy.friction
    assert np.ptp(total) < 1e-10 * largest
    assert (np.abs(energy.friction[-1]) > 1e-4 * largest) == (friction != "none")
    if is_moving:
        # Friction acts on vectors midway, which in space are not quite orthogonal.
        limit = 1e-8 if friction != "none" and scene.dim == 3 else 1e-10
        for momentum in momenta(scene, run):
            assert np.abs(momentum - momentum[0]).max() < limit * np.abs(momentum).max()


EQUAL = {
    "capsule": (
        ancf.Capsule((-0.01, 0, -9), (0.01, 0, 9), 0.07),
        ancf.Drum((0, 0, 0), 0.07, axis=(0.02, 0, 18)),
    ),
    "block": (
        ancf.Block((0, 0, 0), (0.14, 0.14, 0.14), 0.07, (0.6, 0, 0.8, 0)),
        ancf.Ball((0, 0, 0), 0.07),
    ),
    "plate": (
        ancf.Block((0, -0.5), (90, 1), 0.0, np.arctan(-0.1)),
        ancf.HalfSpace((0, 0.5 * (1.01**0.5 - 1.0)), (0.1, 1)),
    ),
}


@pytest.mark.filterwarnings("ignore:.*no force on a part of the axis:ancfsparse.PenetrationWarning")
@pytest.mark.parametrize("friction", FRICTION)
@pytest.mark.parametrize("integrator", [ancf.EnergyMomentum(), ancf.GeneralizedAlpha(0.9)])
@pytest.mark.parametrize(
    ("name", "is_moving"), [(n, n == "block") for n in EQUAL] + [("block", False)]
)
def test_equal_shapes_move_equally(name, is_moving, integrator, friction):
    runs = []
    for obstacle in EQUAL[name]:
        scene, contact = struck(obstacle, is_moving, **FRICTION[friction])
        run = ancf.simulate(scene, 0.01, 2e-4, integrator=integrator, tolerance=1e-12)
        assert run.contact_force(contact).pressure.any()
        runs.append(run)
    one, other = runs
    # Normals midway, which both make the work exact, differ to second order in the step.
    limit = 3e-8 if isinstance(integrator, ancf.EnergyMomentum) or is_moving else 1e-9
    assert np.abs(one.q - other.q).max() < limit
    for quantity in ("contact", "friction", "impact_damping"):
        first, second = (getattr(run.energy, quantity) for run in runs)
        assert np.abs(first - second).max() < 1e-7 * one.energy.kinetic.max()


def test_the_impact_on_a_plane_that_moves_is_that_on_one_at_rest():
    """In a frame that moves with a heavy plate, of which the mass is large but finite."""
    runs = []
    for is_moving in (False, True):
        scene = ancf.Scene((0.0, 0.0))
        fall = (0.0, -1.0) if not is_moving else (0.0, -1.5)
        cable = scene.add_beam(
            "thin", (0, 0.0021), (0.3, 0.0021), 8, SECTION, MATERIAL, velocity=fall
        )
        body = None
        if is_moving:
            body = scene.add_body(mass=1e9, inertia=1e9, position=(0.1, -1), velocity=(0, -0.5))
        scene.contact(cable, ancf.HalfSpace((0, 0), (0, 1)), on=body, stiffness=1e5)
        runs.append(ancf.simulate(scene, 0.01, 1e-4, tolerance=1e-12))
    rest, moving = runs
    loss = rest.energy.impact_damping[-1]
    assert loss > 1e-3 * rest.energy.kinetic[0]
    assert moving.energy.impact_damping[-1] == pytest.approx(loss, rel=1e-6)
    assert np.abs(rest.v[:, 1] - moving.v[:, 1] - 0.5).max() < 1e-6


@pytest.mark.parametrize("name", ORIENTED)
def test_scenes_with_shapes_are_stored(name, tmp_path):
    scene, _ = struck(ORIENTED[name], is_moving=True)
    scene.save(tmp_path / "scene.json")
    again = ancf.Scene.load(tmp_path / "scene.json")
    assert again.digest() == scene.digest()
    first, second = (
        ancf.simulate(each, 2e-3, 2e-4, integrator=ancf.EnergyMomentum()) for each in (scene, again)
    )
    assert np.array_equal(first.q, second.q)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ancf.Capsule((0, 0), (1, 0), 0.0), "radius of a capsule"),
        (lambda: ancf.Capsule((0, 1), (0, 1), 1.0), "a capsule has zero length"),
        (lambda: ancf.Capsule((0, 1), (0, 1, 2), 1.0), "the end of a capsule"),
        (lambda: ancf.Block((0, 0), (1, 0)), "length of a block must be positive"),
        (lambda: ancf.Block((0, 0), (1, -1)), "length of a block must be positive"),
        (lambda: ancf.Block((0, 0), (1, 2, 3)), "the size of a block"),
        (lambda: ancf.Block((0, 0), (1, 2), 0.6), "more than half of its smallest length of 1 m"),
        (lambda: ancf.Block((0, 0), (1, 2), -0.1), "radius of the edges of a block"),
        (lambda: ancf.Block((0, 0, 0), (1, 2, 1), 0.1, (1, 1, 0, 0)), "must be a unit quaternion"),
        (lambda: ancf.Torus((0, 0), 0.1, 0.1), "leaves no hole"),
        (lambda: ancf.Torus((0, 0), 0.1, -0.1), "radius of a torus"),
        (lambda: ancf.Torus((0, 0, 0), 0.1, 0.05), "give axis="),
        (lambda: ancf.Torus((0, 0), 0.1, 0.05, (0, 0, 1)), "leave axis out"),
    ],
)
def test_shapes_without_size_are_refused(make, message):
    with pytest.raises(ancf.InputError, match=message):
        make()


@pytest.mark.parametrize(
    ("name", "times"), [("stadium", 2), ("sharp rectangle", 2), ("ring", 2), ("torus", 6)]
)
def test_elements_longer_than_a_quarter_of_the_circumference_are_refused(name, times):
    obstacle = lowered(ORIENTED[name], 0.003)
    pad = (0.0,) * (obstacle.dim - 2)
    message = f"take at least {times} times as many elements"
    for n in (4, 4 * (times - 1), 4 * times):
        scene = ancf.Scene((0.0, 0.0, *pad))
        cable = scene.add_beam("thin", (-0.3, 0, *pad), (0.3, 0, *pad), n, SECTION, MATERIAL)
        if n == 4 * times:
            scene.contact(cable, obstacle, stiffness=1e5)
            continue
        with pytest.raises(ancf.InputError, match=message if n == 4 else "longer than a quarter"):
            scene.contact(cable, obstacle, stiffness=1e5)


@pytest.mark.parametrize("name", [n for n in SHAPES if not n.startswith("sharp")])
def test_the_default_stiffness_lets_a_tight_wire_sink_in_by_one_per_cent(name):
    scene, contact = struck(ORIENTED[name], is_moving=False)
    obstacle, tension = contact.obstacle, 50.0
    scene = ancf.Scene(scene.gravity)
    pad = (0.0,) * (obstacle.dim - 2)
    cable = scene.add_beam("thin", (-0.3, 0, *pad), (0.3, 0, *pad), 24, SECTION, MATERIAL)
    scene.point_force(cable.end, (tension, 0.0, *pad))
    contact = scene.contact(cable, obstacle)
    system = System(scene)
    part = next(each for each in system.contributions if hasattr(each, "contact"))
    bend = {"ring": 0.07}.get(name, obstacle.radius)
    expected = 2.0 * tension / (bend + 0.002) / (0.01 * 0.002)
    assert part.stiffness == pytest.approx(expected, rel=1e-12)
