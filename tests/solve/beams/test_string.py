"""Strings: the elastic catenary, a taut string's frequencies, and what they share with cables."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import ancfsparse as ancf
from tests.grids import level_grid
from tests.solve.beams.cords import CORD, PER_LENGTH, RUBBER, STIFFNESS, elastic_catenary
from tests.solve.refusals import assert_refused


def hung(n, dim=2, element="string"):
    """A cord of length 1 m between two supports 1 m apart, in its equilibrium."""
    space = (0.0,) * (dim - 2)
    scene = ancf.Scene(gravity=(0.0, *space, -9.81) if dim == 3 else (0.0, -9.81))
    cord = scene.add_beam(element, (0.0, 0.0, *space), (1.0, 0.0, *space), n, CORD, RUBBER)
    scene.pin(cord.start)
    scene.pin(cord.end)
    return cord, ancf.solve_static(scene)


@pytest.mark.parametrize("dim", [2, 3])
def test_sag_and_force_of_an_elastic_catenary_at_second_order(dim):
    sag, force = elastic_catenary(1.0, 1.0)
    errors = []
    for n in (8, 16, 32):
        cord, rest = hung(n, dim)
        errors.append(abs(-rest.position(cord.node(n // 2))[-1] - sag))
        pull = abs(rest.reaction(cord.start)[0])
        assert pull == pytest.approx(force, rel=4.0 / n**2)
    assert errors[-1] < 2e-5
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(orders, 2.0, atol=0.05)


def test_a_cable_whose_bending_is_negligible_hangs_like_a_string():
    cord, rest = hung(64)
    cable, other = hung(64, element="thin")
    middle = [r.position(c.node(32))[1] for r, c in ((rest, cord), (other, cable))]
    # Bending: E I pi^2 / (H L^2) = 1.2 % of the force, and as much of the sag.
    assert middle[0] == pytest.approx(middle[1], rel=0.012)


def test_frequencies_of_a_taut_string_at_second_order():
    """f_k = k / 2 L sqrt(T / rho A) with L the stretched length and rho A of the stretched cord."""
    stretch = 1.1
    tension = STIFFNESS * (stretch - 1.0)
    density = 1000.0 * CORD.area / stretch
    wanted = np.arange(1, 4) / (2.0 * stretch) * np.sqrt(tension / density)
    errors = []
    for n in (16, 32):
        scene = ancf.Scene(gravity=(0.0, 0.0))
        cord = scene.add_beam("string", (0.0, 0.0), (1.0, 0.0), n, CORD, RUBBER)
        scene.pin(cord.start)
        scene.drive(cord.end, (stretch, 0.0))
        modes = ancf.modes(ancf.solve_static(scene), 3)
        errors.append(np.abs(modes.frequencies / wanted - 1.0))
    np.testing.assert_allclose(np.log2(errors[0] / errors[1]), 2.0, atol=0.02)
    # The consistent mass of linear elements: (k pi / n)^2 / 24 too high.
    np.testing.assert_allclose(errors[1], (np.arange(1, 4) * np.pi / 32) ** 2 / 24.0, rtol=0.01)


def swinging(dim=2, velocity=None):
    scene = ancf.Scene(gravity=(0.0, -9.81) if dim == 2 else (0.0, 0.0, -9.81))
    space = (0.0,) * (dim - 2)
    cord = scene.add_beam(
        "string", (0.0, 0.0, *space), (1.0, 0.0, *space), 10, CORD, RUBBER, velocity=velocity
    )
    scene.pin(cord.start)
    return scene, cord


def test_energy_momentum_keeps_the_energy_of_a_swinging_string():
    scene, _ = swinging(3, lambda x: np.stack([0 * x[:, 0], x[:, 0], 0 * x[:, 0]], axis=1))
    run = ancf.simulate(scene, 0.5, dt=2e-3, integrator=ancf.EnergyMomentum(), tolerance=1e-9)
    total = run.energy.total
    assert np.ptp(total) < 1e-9 * np.ptp(run.energy.kinetic)


def test_every_solver_and_an_explicit_integrator_give_the_same_motion():
    scene, cord = swinging()
    reference = ancf.simulate(scene, 0.3, dt=1e-5, integrator=ancf.RungeKuttaNystrom(4))
    wanted = reference.position(cord.end)[-1]
    for solver in ("auto", ancf.Newton(), ancf.ModifiedNewton(), ancf.QuasiNewton("bfgs")):
        ends = [
            ancf.simulate(scene, 0.3, dt=dt, solver=solver).position(cord.end)[-1]
            for dt in (1e-3, 5e-4)
        ]
        errors = [np.linalg.norm(end - wanted) for end in ends]
        assert errors[0] < 1e-3
        assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3)


def test_results_of_a_string():
    cord, rest = hung(16)
    _, force = elastic_catenary(1.0, 1.0)
    section = rest.section_force(cord)
    # In the middle of an element the force of the whole cord, second order in the mesh.
    assert section.force[:, 0] == pytest.approx(force, rel=0.01)
    np.testing.assert_allclose(section.Q, 0.0, atol=1e-9 * force)
    np.testing.assert_allclose(section.M, 0.0, atol=1e-9 * force)
    np.testing.assert_allclose(rest.strain(cord), section.N / STIFFNESS, rtol=1e-9)
    np.testing.assert_array_equal(rest.curvature(cord), 0.0)
    inside = rest.slope(cord.at(0.03))
    assert np.linalg.norm(inside) == pytest.approx(1.0 + rest.strain(cord)[0], rel=1e-12)
    first, second = (rest.position(cord.node(k)) for k in (0, 1))
    np.testing.assert_allclose(
        rest.position(cord.at(0.25 / 16)), 0.75 * first + 0.25 * second, atol=1e-15
    )


def flat_net(n):
    """A net of strings that nothing holds against weight while it is flat."""
    scene = ancf.Scene(gravity=(0.0, 0.0, -9.81))
    nodes, edges, number = level_grid(n + 1)
    net = scene.add_mesh(nodes, edges, element="string", section=CORD, material=RUBBER)
    corners = [net.node(int(k)) for k in number[[0, 0, -1, -1], [0, -1, 0, -1]]]
    for corner in corners:
        scene.pin(corner)
    return scene, net, corners


@pytest.mark.parametrize("factorization", ["complete", "incomplete"])
def test_a_flat_net_of_strings_finds_its_sag_with_either_seed(factorization):
    scene, _, corners = flat_net(14)
    rest = ancf.solve_static(scene, factorization=factorization)
    assert rest.stable
    up = sum(rest.reaction(corner)[2] for corner in corners)
    assert up == pytest.approx(2 * 15 * PER_LENGTH, rel=1e-8)


def test_a_net_of_strings_has_three_coordinates_a_node():
    scene, _, _ = flat_net(2)
    assert ancf.simulate(scene, 0.01, dt=1e-3).q.shape[1] == 27


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda scene, cord: scene.clamp(cord.start), "a clamp needs a direction"),
        (lambda scene, cord: scene.point_moment(cord.end, 1.0), "a moment needs a direction"),
        (lambda scene, cord: scene.add_mass(cord.end, 1.0, inertia=0.1), "a rotary inertia needs"),
        (lambda scene, cord: scene.weld(cord.end), "a weld needs a direction"),
    ],
)
def test_what_needs_a_direction_is_refused_at_a_string(spoil, words):
    scene, cord = swinging()
    assert_refused(words, spoil, scene, cord)


def test_the_slope_at_a_node_of_a_string_is_refused():
    scene, cord = swinging()
    run = ancf.simulate(scene, 0.01, dt=1e-3)
    assert_refused("jumps at its nodes", run.slope, cord.node(3))


def test_a_string_is_written_read_and_drawn(tmp_path):
    scene, _ = swinging()
    run = ancf.simulate(scene, 0.05, dt=1e-3, output=tmp_path / "run.h5")
    again = ancf.load(tmp_path / "run.h5")
    np.testing.assert_array_equal(again.q, run.q)
    run.to_vtk(tmp_path / "run.vtkhdf")
    plt.close(run.plot().figure)
    scene.save(tmp_path / "scene.json")
    assert ancf.Scene.load(tmp_path / "scene.json") == scene
    assert scene.refined(2).bodies[0].n_elements == 20
