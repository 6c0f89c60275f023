"""Complex modes: bars with dashpots by formula, dense problems, forces without a potential."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.solve.vibration import quadratic_eigenproblem
from tests.matrices import full

SOFT = ancf.Material(1e7, 1000.0)


def bar(n, damper, *, time=1.0):
    """A bar of 1 m, too stiff to bend, held at one end, with a dashpot along it at the other."""
    scene = ancf.Scene((0.0, 0.0))
    section = ancf.Section(1e-4, 1e-2, 1e-2, 1e-2)
    rod = scene.add_beam("thin", (0, 0), (1, 0), n, section, ancf.Material(1e7 / time**2, 1000.0))
    scene.clamp(rod.start)
    scene.spring(rod.end, (2.0, 0.0), damping=damper)
    return scene, rod


def by_formula(ratio, k):
    """Roots ``w L / c`` of ``tanh(w L / c) = -Z / damper`` with Z = sqrt(EA rhoA)."""
    if ratio < 1.0:
        return -math.atanh(ratio) + 1j * math.pi * (np.arange(k) + 0.5)
    return -math.atanh(1.0 / ratio) + 1j * math.pi * np.arange(k)


@pytest.mark.parametrize("n", [12, 60])  # a dense problem, and a sparse one
@pytest.mark.parametrize("ratio", [1e-3, 0.5, 0.98, 1.2, 20.0])
def test_a_bar_with_a_dashpot_at_its_end(n, ratio):
    impedance, speed = math.sqrt(1e3 * 0.1), 100.0
    scene, _ = bar(n, ratio * impedance)
    found = ancf.complex_modes(scene, 4)
    np.testing.assert_allclose(found.eigenvalues / speed, by_formula(ratio, 4), rtol=2e-5)
    assert found.stable
    np.testing.assert_allclose(
        found.damping, -found.eigenvalues.real / np.abs(found.eigenvalues), rtol=1e-14
    )


def test_the_bar_to_the_order_of_the_mesh():
    ratio, errors = 0.5, []
    for n in (4, 8, 16):
        found = ancf.complex_modes(bar(n, ratio * 10.0)[0], 2).eigenvalues / 100.0
        errors.append(np.abs(found - by_formula(ratio, 2)))
    orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    # The waves lose their energy at the node of the dashpot, where the slope is its own variable.
    assert orders[-1].min() > 3.8


def test_without_damping_the_modes_are_those_of_modes():
    scene = ancf.Scene((0.0, 0.0, -9.81))
    cable = scene.add_beam("thin", (0, 0, 0), (1, 0, 0), 14, ancf.Circle(0.01), SOFT)
    scene.clamp(cable.start)
    scene.rod(cable.end, (1.0, 0.3, 0.8))
    rest = ancf.solve_static(scene)
    plain, found = ancf.modes(rest, 6), ancf.complex_modes(rest, 6)
    np.testing.assert_allclose(found.frequencies, plain.frequencies, rtol=1e-8)
    assert np.abs(found.growth).max() < 1e-8 * found.frequencies[0]
    assert found.stable
    gradients = rest.system.constraints.jacobian(rest.q)
    assert np.abs(gradients @ found.shapes.T).max() < 1e-9 * np.abs(found.shapes).max()


@pytest.mark.parametrize("n", [4, 50])
def test_free_motions_come_once_and_are_exactly_zero(n):
    scene = ancf.Scene((0.0, 0.0))
    scene.add_beam("thin", (0, 0), (1, 0.4), n, ancf.Circle(0.01), SOFT)
    found = ancf.complex_modes(scene, 5)
    assert (found.eigenvalues[:3] == 0.0).all()
    assert np.isnan(found.damping[:3]).all()
    np.testing.assert_allclose(
        found.frequencies[3:], ancf.modes(scene, 5).frequencies[3:], rtol=1e-7
    )
    assert np.linalg.matrix_rank(found.shapes[:3].real, tol=1e-6) == 3


def test_damping_of_the_masses_lets_free_motions_decay():
    material = ancf.Material(1e7, 1000.0, rayleigh=(0.4, 0.0))
    scene = ancf.Scene((0.0, 0.0))
    scene.add_beam("thin", (0, 0), (1, 0), 6, ancf.Circle(0.01), material)
    found = ancf.complex_modes(scene, 6)
    assert (found.eigenvalues[:3] == 0.0).all()
    np.testing.assert_allclose(found.eigenvalues[3:], -0.4, rtol=1e-6)
    assert (found.damping[3:] == 1.0).all()


@pytest.mark.parametrize("n", [5, 25])
def test_a_gyroscopic_force_without_a_potential_against_a_dense_problem(n):
    # v turned by 90 degrees does no work: a charge in a magnetic field, at the tip of a beam.
    strength = 0.3
    scene = ancf.Scene((0.0, 0.0, 0.0))
    rod = scene.add_beam("thin", (0, 0, 0), (1, 0, 0), n, ancf.Circle(0.01), SOFT)
    scene.clamp(rod.start)
    scene.force(rod.end, lambda q, v, t: strength * np.stack([0 * v[:, 0], v[:, 2], -v[:, 1]], 1))
    found = ancf.complex_modes(scene, 4)
    assert found.stable
    assert np.abs(found.growth).max() < 1e-7 * np.abs(found.eigenvalues[0])
    system = found.system
    args, n_free = (found.about.q, np.zeros(0), np.zeros(1)), system.n_free
    matrices = (system.assembly.matrix(*each, *args) for each in ((1.0, 0.0), (0.0, 1.0)))
    mass, stiffness = (full(system, values) for values in matrices)
    damping = np.zeros((n_free, n_free))
    _, y, z = system.point(rod.end)[0][:, 0]
    damping[y, z], damping[z, y] = -strength, strength
    zero, one = np.zeros_like(mass), np.eye(len(mass))
    roots = np.linalg.eigvals(
        np.block([[zero, one], [-np.linalg.solve(mass, np.hstack([stiffness, damping]))]])
    )
    roots = roots[roots.imag > 0.0]
    roots = roots[np.argsort(np.abs(roots))][:4]
    np.testing.assert_allclose(found.frequencies * 2.0 * np.pi, roots.imag, rtol=1e-6)
    # Without the force frequencies come in equal pairs; it splits them.
    assert np.diff(found.frequencies)[0] > 0.01 * found.frequencies[0]


def test_the_motion_in_a_damped_mode_decays_as_its_eigenvalue_says():
    scene, rod = bar(8, 4.0)
    found = ancf.complex_modes(scene, 1)
    start = found.moving(0, 1e-6)
    period = 1.0 / found.frequencies[0]
    run = ancf.simulate(scene, period, period / 400, start=start, tolerance=1e-11)
    shape = found.displacement(rod.end)[0, 0] / np.real(found.displacement(rod.end)[0, 0])
    exact = 1e-6 * np.real(shape * np.exp(found.eigenvalues[0] * run.t))
    np.testing.assert_allclose(run.position(rod.end)[:, 0] - 1.0, exact, atol=2e-10)


def test_complex_modes_do_not_depend_on_units():
    one, other = (
        ancf.complex_modes(bar(40, 4.0 / time, time=time)[0], 3).eigenvalues * time
        for time in (1.0, 1e4)
    )
    np.testing.assert_allclose(other, one, rtol=1e-9)


def test_a_picture_of_a_complex_mode():
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    found = ancf.complex_modes(bar(4, 3.0)[0], 2)
    ax = found.plot(1, 0.05)
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert any("damping" in text for text in texts)
    plt.close(ax.figure)
    assert "2 modes" in repr(found)


@pytest.mark.parametrize("by_multipliers", [False, True])
@pytest.mark.parametrize("dampings", [(30.0, 60.0), (30.0, 0.5), (0.0, 60.0), (3e4, 60.0)])
def test_an_overdamped_degree_of_freedom_has_two_motions(dampings, by_multipliers):
    scene, mass, stiffness, roots = ancf.Scene(gravity=(0, 0)), 2.0, 50.0, []
    axis = np.array([0.8, 0.6] if by_multipliers else [1.0, 0.0])
    for damping in dampings:
        body = scene.add_body(position=axis, mass=mass, inertia=0.1)
        scene.prismatic(body.origin, axis=axis)
        scene.spring(body.origin, (0, 0), stiffness=stiffness, damping=damping)
        # The rounding of roots by the formula of quadratic equations would exceed that of modes.
        fast = np.roots([mass, damping, stiffness])[0]
        roots += [fast] if fast.imag else [fast, stiffness / mass / fast]
    roots = np.array(sorted(roots, key=abs))
    roots = roots.real + 1j * np.abs(roots.imag)
    found = ancf.complex_modes(scene, len(roots))
    np.testing.assert_allclose(found.eigenvalues, roots, rtol=1e-9, atol=found.rounding.max())
    np.testing.assert_allclose(ancf.complex_modes(scene, 2).eigenvalues, roots[:2], rtol=1e-9)
    with pytest.raises(InputError, match=f"at most {len(roots)} in this scene, got 5"):
        ancf.complex_modes(scene, 5)


def test_inaccurate_motions_are_refined(monkeypatch):
    """Another LAPACK gives other rounding: here all motions are wrong by 1e-4."""
    scene, _ = bar(4, 3.0)
    exact = ancf.complex_modes(scene, 4)
    solve = quadratic_eigenproblem._solve_dense

    def spoil(damped, motions):
        values, vectors = solve(damped, motions)
        noise = np.random.default_rng(0).standard_normal(vectors.shape)
        return values, vectors * (1.0 + 1e-4 * noise)

    monkeypatch.setattr(quadratic_eigenproblem, "_solve_dense", spoil)
    found = ancf.complex_modes(scene, 4)
    np.testing.assert_allclose(found.eigenvalues, exact.eigenvalues, rtol=1e-12)
    for mode in range(4):
        one, other = (each.state(mode, 1e-3).q for each in (found, exact))
        np.testing.assert_allclose(one, other, atol=1e-12)


def test_what_is_asked_of_complex_modes_is_checked():
    scene, _ = bar(4, 3.0)
    with pytest.raises(InputError, match="n must be at most"):
        ancf.complex_modes(scene, 1000)
    with pytest.raises(InputError, match="modes are those of a scene"):
        ancf.complex_modes(3, 1)
