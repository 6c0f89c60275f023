"""Modes about loaded states: dense problems by differences, motions in time, other units."""

import math

import numpy as np
import pytest
from scipy.linalg import eig, eigh, null_space

import ancfsparse as ancf
from ancfsparse.errors import ApproximateModesWarning, InputError, RedundantConstraintsWarning
from ancfsparse.problems import chain, net
from ancfsparse.seeds import SparseSeed
from ancfsparse.system import System
from tests.beams import build_beam
from tests.matrices import full

SOFT, STEEL = ancf.Material(1e7, 1000.0), ancf.Material(2e11, 7800.0)


def hung(n=14, *, damping=0.0, size=1.0, stress=1.0, mass=1.0, time=1.0):
    """A cable and a body between rods, in units of some size, stress, mass and time."""
    gravity = 9.81 * size / time**2
    scene = ancf.Scene((0.0, 0.0, -gravity))
    density = 1000.0 * mass / size**3
    material = ancf.Material(1e7 * stress, density, bending_damping=damping)
    section = ancf.Circle(0.01 * size)
    cable = scene.add_beam("thin", (0, 0, 0), (size, 0, 0), n, section, material)
    scene.clamp(cable.start)
    scene.rod(cable.end, (size, 0.3 * size, 0.8 * size))
    scene.add_mass(cable.at(0.5 * size), 0.1 * mass)
    scene.spring(cable.at(0.7 * size), (0.7 * size, -size, 0.0), stiffness=3.0 * mass / time**2)
    return scene, cable


def by_differences(rest):
    """Squares of all angular frequencies from differences of forces, on a dense basis."""
    system, q, lam = rest.system, rest.q, rest.lam
    none, amplitudes = np.zeros_like(q), system.loads.amplitudes(np.zeros(1))[0]
    n = system.n_free

    def change(j, small=1e-6):
        out = []
        for sign in (1.0, -1.0):
            moved = q.copy()
            moved[j] += sign * small
            args = (none, none, lam, system.dead_load, amplitudes)
            out.append(system.assembly.residual(moved, *args))
        return [(a - b)[:size] / (2.0 * small) for a, b, size in zip(*out, (n, None), strict=True)]

    columns = [change(j) for j in range(n)]
    stiffness, gradients = (np.stack(each, axis=1) for each in zip(*columns, strict=True))
    mass = np.stack([system.assembly.inertia(row)[:n] for row in np.eye(n, len(q))], axis=1)
    allowed = null_space(gradients)
    stiffness = 0.5 * (stiffness + stiffness.T)
    return eigh(allowed.T @ stiffness @ allowed, allowed.T @ mass @ allowed, eigvals_only=True)


@pytest.mark.parametrize("n", [6, 30])
def test_modes_about_a_loaded_state_with_multipliers_are_those_of_dense_differences(n):
    rest = ancf.solve_static(hung(n)[0])
    assert len(rest.lam)
    found = ancf.modes(rest, 8)
    np.testing.assert_allclose(found.eigenvalues, by_differences(rest)[:8], rtol=1e-5)
    gradients = rest.system.constraints.jacobian(rest.q)
    assert np.abs(gradients @ found.shapes.T).max() < 1e-10 * np.abs(found.shapes).max()


def test_a_small_vibration_in_time_has_the_period_of_its_mode():
    scene, cable = hung(8)
    rest = ancf.solve_static(scene)
    found = ancf.modes(rest, 2)
    period = 1.0 / found.frequencies[1]
    start = found.state(1, 1e-5)
    dt = period / 400
    run = ancf.simulate(scene, 1.5 * period, dt, start=start, tolerance=1e-10)
    node = cable.at(0.4)
    moved = (run.position(node) - rest.position(node)) @ found.displacement(node)[1]
    # It comes back to where it was after one period, and is on the other side after half of one.
    assert moved[0] > 0.0
    crossings = np.flatnonzero(moved[:-1] * moved[1:] < 0.0)
    share = moved[crossings] / (moved[crossings] - moved[crossings + 1])
    times = run.t[crossings] + dt * share
    np.testing.assert_allclose(times, period * np.array([0.25, 0.75, 1.25]), rtol=1e-3)


def test_modes_do_not_depend_on_units():
    # Metres, kilograms and seconds, and micrometres, tonnes and minutes.
    kinds = {"size": 1e6, "mass": 1e-3, "time": 1.0 / 60.0}
    kinds["stress"] = kinds["mass"] / (kinds["size"] * kinds["time"] ** 2)
    one, other = (ancf.modes(ancf.solve_static(hung(30, **each)[0]), 6) for each in ({}, kinds))
    np.testing.assert_allclose(other.frequencies * kinds["time"], one.frequencies, rtol=1e-7)


def test_free_motions_are_found_in_any_units():
    for size, mass, time in ((1.0, 1.0, 1.0), (1e6, 1e-3, 1.0 / 60.0), (1e-4, 1e5, 1e7)):
        scene = ancf.Scene((0.0, 0.0))
        material = ancf.Material(1e11 * mass / (size * time**2), 1e3 * mass / size**3)
        section = ancf.Rectangle(0.01 * size, 0.01 * size)
        scene.add_beam("thin", (0, 0), (size, 0.3 * size), 50, section, material)
        scene.add_body(
            mass=mass, inertia=0.1 * mass * size**2, position=(0.0, size), orientation=0.3
        )
        found = ancf.modes(scene, 8)
        assert (found.frequencies[:6] == 0.0).all()
        assert found.frequencies[6] > 0.0
        first = found.frequencies[6] * time
        known = 4.730040744862704**2 / (2 * math.pi * 1.09) * math.sqrt(1e8 * 1e-4 / 12.0)
        np.testing.assert_allclose(first, known, rtol=1e-5)


@pytest.mark.parametrize("beside", [0, 40])
def test_a_door_on_two_pins_of_which_one_equation_is_redundant(beside):
    scene = ancf.Scene((0.0, -9.81, 0.0))
    door = scene.add_body(
        ancf.Box(length=0.4, width=0.1, height=0.6), mass=3.0, position=(0.0, -0.3, 0.0)
    )
    scene.pin(door.at((-0.2, 0.3, 0.0)))
    scene.pin(door.at((0.2, 0.3, 0.0)))
    if beside:  # so many coordinates that the problem is a sparse one
        rod = scene.add_beam("thin", (2, 0, 0), (2.3, 0, 0), beside, ancf.Circle(0.01), STEEL)
        scene.clamp(rod.start)
    with pytest.warns(RedundantConstraintsWarning):
        last = ancf.simulate(scene, 1e-3, 1e-3).last
    found = ancf.modes(scene, 1, at=last)
    inertia = 3.0 * ((0.6**2 + 0.1**2) / 12.0 + 0.3**2)
    np.testing.assert_allclose(found.eigenvalues[0], 3.0 * 9.81 * 0.3 / inertia, rtol=1e-11)


@pytest.mark.parametrize("edge", [12, 24, pytest.param(71, marks=pytest.mark.slow)])
def test_the_work_does_not_grow_with_the_mesh(monkeypatch, edge):
    counts = {"factor": 0, "solve": 0}

    def counted(name):
        plain = getattr(SparseSeed, name)

        def call(self, *args):
            counts[name] += 1
            return plain(self, *args)

        monkeypatch.setattr(SparseSeed, name, call)

    for name in counts:
        counted(name)
    ancf.modes(net(edge).scene, 20)  # up to 10 082 elements, which take 3 s of one processor
    assert counts["factor"] <= 4
    assert counts["solve"] <= 260


def test_a_square_net_has_all_its_pairs():
    # Four equal corners: many frequencies are double, and none may be left out.
    rest = ancf.solve_static(net(9).scene)
    found = ancf.modes(rest, 20)
    np.testing.assert_allclose(found.eigenvalues, by_differences(rest)[:20], rtol=1e-4)


def test_a_state_in_another_scene_of_the_same_bodies():
    scene, _ = hung(8)
    rest = ancf.solve_static(scene)
    run = ancf.simulate(scene, 1e-3, 1e-3, start=rest)
    about = ancf.modes(scene, 4, at=run.last)
    np.testing.assert_allclose(about.frequencies, ancf.modes(rest, 4).frequencies, rtol=1e-6)


def test_damping_ratios_of_rayleigh_and_of_retardation():
    def ratios(**damping):
        scene = ancf.Scene((0.0, 0.0))
        material = ancf.Material(1e9, 1000.0, **damping)
        rod = scene.add_beam("thin", (0, 0), (1, 0), 10, ancf.Circle(0.01), material)
        scene.clamp(rod.start)
        found = ancf.modes(scene, 3)
        return found.damping, 2.0 * math.pi * found.frequencies

    ratio, omega = ratios(rayleigh=(0.2, 1e-3))
    np.testing.assert_allclose(ratio, 0.1 / omega + 0.5e-3 * omega, rtol=1e-9)
    ratio, omega = ratios(bending_damping=2e-3)
    np.testing.assert_allclose(ratio, 1e-3 * omega, rtol=1e-9)
    assert (ratios()[0] == 0.0).all()


def test_the_ratio_of_a_dashpot_is_of_first_order():
    def ratios(damping):
        scene = ancf.Scene((0.0, 0.0))
        rod = scene.add_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.01), SOFT)
        scene.clamp(rod.start)
        scene.spring(rod.at(0.6), (0.6, 1.0), damping=damping)
        found = ancf.modes(scene, 3)
        system, q = found.system, found.about.q
        n, none = system.n_free, np.zeros(0)
        args = (q, none, none)
        small = [
            system.assembly.matrix(*factors, *args, damping_factor=c, v=np.zeros_like(q))
            for *factors, c in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
        ]
        m, k, c = (full(system, values) for values in small)
        whole = np.block([[np.zeros((n, n)), np.eye(n)], [-k, -c]])
        roots = eig(whole, np.kron(np.diag([1.0, 0.0]), np.eye(n)) + np.kron(np.diag([0, 1]), m))[0]
        roots = roots[(roots.imag > 0.0)]
        roots = roots[np.argsort(np.abs(roots))][:3]
        return found.damping, -roots.real / np.abs(roots)

    offs = []
    for damping in (2e-2, 1e-2):
        ratio, exact = ratios(damping)
        offs.append(np.abs(ratio / exact - 1.0))
    assert offs[0].max() < 0.02
    np.testing.assert_allclose(offs[0] / offs[1], 4.0, rtol=0.05)


def test_masses_that_take_part_add_up():
    scene, rod = build_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.01), SOFT, gravity=(0.0, 0.0))
    scene.rod(rod.end, (2.0, 3.0))
    found = ancf.modes(scene, 19)
    assert np.all(found.effective_masses >= 0.0)
    free = ancf.modes(_free(), 20).effective_masses.sum(axis=0)
    np.testing.assert_allclose(free, System(scene).mass, rtol=1e-9)
    assert found.effective_masses.sum() < free.sum()


def _free():
    scene = ancf.Scene((0.0, 0.0))
    scene.add_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.01), SOFT)
    return scene


def test_what_is_asked_for_is_checked():
    scene = _free()
    with pytest.raises(InputError, match="at most 20 in this scene, got 21"):
        ancf.modes(scene, 21)
    with pytest.raises(InputError, match="memory are free"):
        ancf.modes(scene, np.uint64(2**64 - 1))
    with pytest.raises(InputError, match="n must"):
        ancf.modes(scene, 0)
    last = ancf.simulate(scene, 0.01, 0.01).last
    with pytest.raises(InputError, match="modes\\(scene, n, at=state\\)"):
        ancf.modes(last, 3)
    hanging, _ = hung(4)
    with pytest.raises(InputError, match="state already"):
        ancf.modes(ancf.solve_static(hanging), 3, at=last)
    found = ancf.modes(scene, 4)
    with pytest.raises(InputError, match="counts from 0 to 3"):
        found.state(4, 0.1)
    with pytest.raises(InputError, match="amplitude"):
        found.state(0, math.nan)


def test_forces_without_a_potential_are_named():
    scene = _free()
    scene.force(scene.beams[0].end, lambda q, v, t: q[:, ::-1] * (np.arange(q.shape[1]) == 0))
    with pytest.warns(ApproximateModesWarning, match="symmetric part"):
        ancf.modes(scene, 4)


def test_a_picture_of_a_mode():
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    scene, cable = hung(6)
    found = ancf.modes(ancf.solve_static(scene), 3)
    ax = found.plot(1)
    assert f"mode 1, {found.frequencies[1]:.4g} Hz" in [
        text.get_text() for text in ax.get_legend().get_texts()
    ]
    plt.close(ax.figure)
    np.testing.assert_allclose(found.position(cable.end), found.about.q[_place(found, cable.end)])
    farthest = found.state(1, 0.02)
    moved = [
        np.linalg.norm(farthest.q[p[:, :3]] - found.about.q[p[:, :3]], axis=1).max()
        for p in farthest.layout.places
    ]
    np.testing.assert_allclose(max(moved), 0.02, rtol=1e-12)


def _place(found, node):
    return found.system.point(node)[0][:, 0]


@pytest.mark.slow
def test_modes_that_are_lost_in_rounding_end_with_a_sentence(monkeypatch):
    """A long chain without tension took up to ten restarts for each of its coordinates."""
    monkeypatch.setattr("ancfsparse.solve.vibration.symmetric_eigenproblem.MAX_RESTARTS", 2)
    scene, _ = chain(30_000)
    with pytest.raises(ancf.ModesError, match=r"lost in the rounding .* below about .* Hz; take"):
        ancf.modes(scene, 10)


def held(drive):
    """A rod on a pin whose other end is held, or whose angle is driven."""
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0))
    pin = scene.pin(rod.origin)
    if drive:
        scene.drive_joint(pin, ancf.Ramp(1.0, 1.0, smooth=True))
    else:
        scene.rod(rod.end, (1, 2))
    return scene


@pytest.mark.parametrize("drive", [True, False])
@pytest.mark.parametrize("find", [ancf.modes, ancf.complex_modes])
def test_where_nothing_can_move_there_is_no_mode(find, drive):
    with pytest.raises(InputError, match="leave nothing that can vibrate"):
        find(held(drive), 1)
