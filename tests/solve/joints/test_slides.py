"""Points that slide along beams: a wire, a rope as in Exudyn, passage, the end, in space."""

from __future__ import annotations

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.scene.kinematics.sliding_curve import CurveOffset
from ancfsparse.system import System
from tests.beams import build_beam
from tests.matrices import stiffness
from tests.solve.refusals import assert_refused

G = 9.81
DAMPED = ancf.GeneralizedAlpha(0.9)


SIDE = math.sqrt(12.0 * 0.0833333 / 1e4)
PAPER = ancf.Rectangle(SIDE, SIDE), ancf.Material(1e4 / SIDE**2, 0.4 / SIDE**2)
"""Section and material of a cable of EA 1e4 N, EI 0.0833333 N m2, 0.4 kg/m."""


def bead_at(scene, x, **options):
    return scene.add_body(mass=0.1, inertia=1e-4, position=(x, 0), **options)


def rope_of_the_paper(n):
    """A cable between two pins, and a bead on it."""
    scene, rope = build_beam(
        "thin", (0, 0), (2, 0), n, *PAPER, "pin", "pin", gravity=(0.0, -G), strain="biot"
    )
    body = bead_at(scene, 0.5)
    return scene, rope, body, scene.slide(body.origin, rope)


@pytest.mark.parametrize("solver", [ancf.Newton(), ancf.QuasiNewton("bfgs"), "auto"], ids=repr)
def test_a_bead_slides_down_a_rope_as_in_exudyn(solver):
    # Exudyn 1.13.6, ANCFCable2D, 16 to 32 elements: within 3e-4 m.
    scene, rope, body, _ = rope_of_the_paper(24)
    run = ancf.simulate(scene, 0.5, 1e-3, integrator=DAMPED, solver=solver)
    place = run.position(body.origin)
    np.testing.assert_allclose(place[250], [0.52439, -0.03514], atol=3e-4)
    np.testing.assert_allclose(place[500], [0.5995, -0.09880], atol=3e-4)
    np.testing.assert_allclose(run.position(rope.node(12))[500], [0.99904, -0.10603], atol=3e-4)


def test_energy_is_kept_at_second_order():
    drifts = []
    for dt in (1e-3, 5e-4):
        scene, *_ = rope_of_the_paper(8)
        drifts.append(ancf.simulate(scene, 0.5, dt, integrator=DAMPED).energy.drift)
    assert drifts[1] < 2e-4
    assert 3.5 < drifts[0] / drifts[1] < 4.5


def test_a_bead_on_a_quarter_circle_is_a_pendulum():
    # 1 m of radius from level down to the bottom and up: T = 4 K(sin 45 deg) sqrt(R / g), the speed
    # at the bottom is sqrt(2 g R), the force there 3 m g.
    scene = ancf.Scene((0.0, -G))
    arc = ancf.Arc(centre=(0, 0), start=(1, 0), angle=-math.pi)
    material = ancf.Material(1e7, 1e3)
    wire = scene.add_beam("thin", curve=arc, n_elements=16, section=ancf.Circle(0.02),
                          material=material)  # fmt: skip
    for k in range(wire.n_nodes):
        scene.clamp(wire.node(k), stretch="fixed")
    body = scene.add_body(mass=0.1, inertia=1e-4, position=(1, 0))
    slide = scene.slide(body.origin, wire)
    run = ancf.simulate(scene, 0.6, 1e-3, integrator=DAMPED)
    speed = np.linalg.norm(run.velocity(body.origin), axis=1)
    bottom = int(np.argmax(speed))
    assert run.t[bottom] == pytest.approx(2.3678419 / 4.0, abs=1.5e-3)
    assert speed[bottom] == pytest.approx(4.4294469, rel=1e-4)
    pull = run.joint_force(slide).force
    np.testing.assert_allclose(pull[bottom], [0.0, 3.0 * 0.1 * G], atol=0.02)
    # The cubic is 3.9e-6 off the circle.
    radius = np.linalg.norm(run.position(body.origin), axis=1)
    np.testing.assert_allclose(radius, 1.0, atol=1e-5)


def held_wire(n, length):
    """A straight wire whose nodes are all held, in a field along it, and a bead."""
    scene, wire = build_beam(
        "thin", (0, 0), (length, 0), n, ancf.Circle(0.02), ancf.Material(1e9, 1e3),
        gravity=(2.0, 0.0),
    )  # fmt: skip
    for node in range(n + 1):
        scene.clamp(wire.node(node), stretch="fixed")
    bead = bead_at(scene, 0.1)
    scene.slide(bead.origin, wire)
    return scene, bead


def test_a_bead_passes_all_elements_of_a_straight_wire_evenly():
    scene, body = held_wire(7, 2.0)
    run = ancf.simulate(scene, 1.3, 0.01, integrator=DAMPED)
    np.testing.assert_allclose(run.position(body.origin)[:, 0], 0.1 + run.t**2, atol=1e-6)


def test_a_bead_that_runs_off_the_end_ends_the_run_and_keeps_the_states_before():
    scene, body = held_wire(4, 1.0)
    with pytest.raises(ancf.LoadError, match=r"ran off its end, to s = 1.* of 1 m") as caught:
        ancf.simulate(scene, 2.0, 0.01, integrator=DAMPED)
    # 0.1 + t^2 = 1 at t = .9487
    assert caught.value.time == pytest.approx(0.955, abs=0.011)
    run = caught.value.trajectory
    assert 0.94 < run.t[-1] < 0.965
    assert 0.98 < run.position(body.origin)[-1, 0] < 1.03


def cable_car(**options):
    """A carriage with a hanging cabin on a rope in space."""
    section, material = ancf.Circle(0.03), ancf.Material(1e9, 5e3)
    scene, rope = build_beam(
        "thin", (0, 0, 0), (20, 0, -2), 20, section, material, "pin", "pin", gravity=(0.0, 0.0, -G)
    )
    at = np.array([4.0, 0.0, -0.4])
    carriage = scene.add_body(mass=2.0, inertia=(0.1, 0.1, 0.1), position=at)
    cabin = scene.add_body(ancf.Rod(1.5), mass=30.0, position=at, orientation=DOWN)
    scene.connect(carriage.origin, cabin.origin)
    return scene, rope, carriage, cabin, scene.slide(carriage.origin, rope, **options)


DOWN = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])


def test_a_cable_car_keeps_to_its_rope_and_its_energy():
    scene, _rope, carriage, _, slide = cable_car()
    run = ancf.simulate(scene, 1.5, 2e-3, integrator=DAMPED)
    offset = next(each for *_, each in run.system.constraints.measures)
    s = np.array([offset.curve.nearest(q) for q in run.q[::50]])
    assert s[-1] - s[0] > 0.5  # it has passed a node
    off = [run.position(carriage.origin)[50 * k] - offset.curve.at(run.q[50 * k], x)[1]
           for k, x in enumerate(s)]  # fmt: skip
    np.testing.assert_allclose(off, 0.0, atol=1e-8)
    assert run.energy.drift < 2e-3
    pull = run.joint_force(slide).force
    tangent = [offset.curve.at(run.q[50 * k], x)[2] for k, x in enumerate(s)]
    along = np.einsum("ki,ki->k", pull[::50], tangent)
    np.testing.assert_allclose(along, 0.0, atol=1e-6 * np.abs(pull).max())


def test_a_run_of_a_slide_goes_on():
    scene, _, _body, _ = rope_of_the_paper(8)
    options = {"integrator": DAMPED, "tolerance": 1e-11}
    whole = ancf.simulate(scene, 0.4, 1e-3, **options)
    half = ancf.simulate(scene, 0.2, 1e-3, **options)
    rest = ancf.simulate(scene, 0.4, 1e-3, start=half.last, **options)
    np.testing.assert_allclose(rest.q[-1], whole.q[-1], rtol=0, atol=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
def test_equations_of_slides_have_their_derivatives(dim):
    scene = ancf.Scene((0.0, -G, 0.0)[:dim])
    section, material = ancf.Circle(0.02), ancf.Material(1e7, 1e3)
    rope = scene.add_beam("thin", np.zeros(dim), 2.0 * np.eye(dim)[0], 4, section, material)
    body = scene.add_body(mass=1.0, inertia=1.0 if dim == 2 else (1, 1, 1), position=np.zeros(dim))
    scene.slide(body.origin, rope)
    system = System(scene)
    rng = np.random.default_rng(1)
    n, none = system.n_free, np.zeros(system.n_all)
    q = system.q_ref + 0.0
    q[:n] += 0.1 * rng.standard_normal(n)
    track = next(e.curve for *_, e in system.constraints.measures if isinstance(e, CurveOffset))
    q[track.point[:, 0]] = track.at(q, 0.6)[1]
    system.assembly.memory = np.array([0.6])
    lam = rng.standard_normal(system.n_multipliers)

    def residual(q, lam):
        return system.assembly.residual(q, none, none, lam, none, np.zeros(1))

    v, step = rng.standard_normal(system.n_all), 1e-6
    phi_q = system.constraints.jacobian(q)
    near = (residual(q + step * v, lam)[1] - residual(q - step * v, lam)[1]) / (2 * step)
    np.testing.assert_allclose(phi_q @ v, near, rtol=1e-6, atol=1e-7)
    push = residual(q, lam)[0] - residual(q, 0.0 * lam)[0]
    np.testing.assert_allclose(push, phi_q.T @ lam, atol=1e-10)
    dense = phi_q.toarray()[:, :n]
    allowed = np.linalg.svd(dense)[2][len(dense) :]
    v = np.append(allowed.T @ (allowed @ v[:n]), np.zeros(system.n_all - n))
    ahead, behind = (system.constraints.jacobian(q + s * step * v) @ v for s in (1, -1))
    bent = system.constraints.curvature(q, v)
    np.testing.assert_allclose(bent, (ahead - behind) / (2 * step), rtol=1e-5, atol=1e-5)
    whole = stiffness(system, q, lam, np.zeros(1)).toarray()
    np.testing.assert_allclose(whole[n:, :n], dense, atol=1e-12)
    near = (residual(q + step * v, lam)[0] - residual(q - step * v, lam)[0])[:n] / (2 * step)
    wrong = allowed @ (whole[:n, :n] @ v[:n] - near)
    assert np.abs(wrong).max() < 1e-7 * np.abs(near).max()


def test_bad_arguments_of_slides():
    scene, rope, body, _ = rope_of_the_paper(4)
    assert_refused(r"cannot slide along itself", scene.slide, rope.node(2), rope)
    assert_refused("needs a beam or a mesh to slide along", scene.slide, body.origin, body)
    off = scene.add_body(mass=0.1, inertia=1e-4, position=(0.5, 0.2))
    for direction in ((0, 1), (0, 0, 1)):
        assert_refused(
            "has no meaning in a planar", scene.slide, off.origin, rope, lateral=direction
        )
    scene.slide(off.origin, rope)
    with pytest.raises(ancf.InputError, match=r"violate the slide of .* by 0\.2 m: move the start"):
        ancf.simulate(scene, 0.1, 0.01)
    assert_refused("lateral of a slide must be across", cable_car, lateral=(1.0, 0.0, -0.1))
    strings = ancf.Scene((0.0, -G))
    material = ancf.Material(1e7, 1e3)
    line = strings.add_beam("string", (0, 0), (1, 0), 4, ancf.Circle(0.02), material)
    bead = strings.add_body(mass=0.1, inertia=1e-4, position=(0.5, 0))
    assert_refused("made of strings", strings.slide, bead.origin, line)


def test_a_point_slides_far_in_statics_however_fine_the_mesh():
    """Beyond thirty elements it stayed on the tangent there: 0.021 m up in place of 0.0026."""
    found = []
    for n in (10, 100, 200):
        scene = ancf.Scene((0.0, 0.0))
        beam = scene.add_beam(
            "thin", (0, 0), (1, 0), n, ancf.Circle(0.01), ancf.Material(2e9, 1000.0)
        )
        scene.clamp(beam.start)
        scene.clamp(beam.end)
        box = scene.add_body(
            ancf.Box(length=0.01, width=0.01, height=0.01), mass=0.1, position=(0.1, 0)
        )
        scene.slide(box.origin, beam)
        scene.spring(box.origin, (0.9, 0.1), stiffness=100.0, length=0.0)
        scene.spring(box.at((0.0, 0.005)), (0.9, 1.0), stiffness=1.0, length=0.0)
        found.append(ancf.solve_static(scene).position(box.origin))
    np.testing.assert_allclose(found[:2], found[2:] * 2, rtol=0.0, atol=2e-5)


def cross(*z):
    """Two crossing cables of a mesh whose ends are held, the first along x over 2 m."""
    scene = ancf.Scene((0.0, -G, *(0.0 for _ in z)))
    nodes = [(0, 0, *z), (1, 0, *z), (2, 0, *z), (1, 1, *z), (1, -1, *z)]
    edges = [(0, 1), (2, 1), (3, 1), (1, 4)]
    net = scene.add_mesh(nodes, edges, "thin", *PAPER, n_elements=4, strain="biot")
    for k in (0, 2, 3, 4):
        scene.pin(net.node(k))
    return scene, net


def test_a_bead_on_a_line_of_a_mesh_moves_as_on_a_beam_and_passes_the_crossing():
    paths = []
    for along in ("beam", "mesh"):
        scene = ancf.Scene((0.0, -G))
        if along == "beam":
            rope = scene.add_beam("thin", (0, 0), (2, 0), 8, *PAPER, strain="biot")
            ends, middle = (rope.start, rope.end), rope.node(4)
        else:
            nodes, edges = [(0, 0), (1, 0), (2, 0)], [(0, 1), (2, 1)]
            rope = scene.add_mesh(nodes, edges, "thin", *PAPER, n_elements=4, strain="biot")
            ends, middle = (rope.node(0), rope.node(2)), rope.node(1)
        for node in ends:
            scene.pin(node)
        bead = bead_at(scene, 0.6, velocity=(2.0, 0.0))
        scene.slide(bead.origin, rope)
        run = ancf.simulate(scene, 0.4, 1e-3, integrator=DAMPED, tolerance=1e-11)
        paths.append(np.hstack([run.position(bead.origin), run.position(middle)]))
    assert paths[0][-1, 0] > 1.1  # beyond the node of three edges
    np.testing.assert_allclose(paths[1], paths[0], atol=1e-8)


def test_a_bead_goes_straight_on_at_a_crossing():
    scene, net = cross()
    bead = bead_at(scene, 0.6, velocity=(3.0, 0.0))
    slide = scene.slide(bead.origin, net)
    run = ancf.simulate(scene, 0.3, 1e-3, integrator=DAMPED)
    assert run.position(bead.origin)[-1, 0] > 1.2
    assert np.abs(run.position(bead.origin)[:, 1]).max() < 0.1
    assert np.isfinite(run.joint_force(slide).force).all()
    assert run.energy.drift < 1e-2


def test_a_ring_slides_along_a_net_in_space_and_off_its_end():
    scene, net = cross(0)
    ring = scene.add_body(ancf.Sphere(0.01), mass=0.1, position=(0.6, 0, 0), velocity=(3.0, 0, 0))
    scene.slide(ring.origin, net, lateral=(0, 0, 1))
    with pytest.raises(ancf.LoadError, match=r"along mesh 0 ran off its end") as found:
        ancf.simulate(scene, 1.0, 2e-3, integrator=DAMPED)
    assert found.value.trajectory.position(ring.origin)[-1, 0] > 1.9


def test_closed_lines_of_meshes_and_strings_are_refused():
    angle = np.linspace(0.0, 2.0 * math.pi, 13)[:-1]
    scene = ancf.Scene((0.0, 0.0))
    ring = [(k, (k + 1) % 12) for k in range(12)]
    net = scene.add_mesh(
        np.stack([np.cos(angle), np.sin(angle)], axis=1), ring, "thin", ancf.Circle(0.01),
        ancf.Material(1e7, 1e3), smooth=60.0,
    )  # fmt: skip
    bead = scene.add_body(mass=0.1, inertia=1e-4, position=(1.0, 0.0))
    assert_refused("on a closed line of mesh 0", scene.slide, bead.origin, net)
    with pytest.raises(ancf.InputError, match="needs a beam or a mesh to slide along, got None"):
        scene.slide(bead.origin, None)
