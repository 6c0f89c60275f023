"""The energy-momentum method: what it keeps, its order, and one step solved a second way."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import root

import ancfsparse as ancf
from ancfsparse.nonlinear import Newton, Outcome
from ancfsparse.nonlinear.iteration import finite_difference
from ancfsparse.problems import chain, pendulum
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System
from benchmarks.stability.scenes import SCENES
from tests.integrators.implicit.test_family import truss
from tests.integrators.points import exact_circle, on_circle, orders
from tests.matrices import full

KEEPS = ancf.EnergyMomentum()
SECTION = ancf.Rectangle(0.01, 0.01)


@pytest.mark.parametrize("element", ["l2t2", "thin", "thick"])
def test_it_is_of_second_order(element):
    # A thick beam is too stiff for long explicit steps: it is held to its own finest run.
    options = {"nu": 0.0, "dim": 2} if element == "thick" else {}
    scene, rod = pendulum(element, 4, youngs_modulus=1e6, **options)
    if element == "thick":
        exact = None
    else:
        run = ancf.simulate(scene, 0.5, 2.5e-4, integrator=ancf.RungeKuttaNystrom(8))
        exact = run.position(rod.end)[-1], run.velocity(rod.end)[-1]
    found = [
        (run.position(rod.end)[-1], run.velocity(rod.end)[-1])
        for dt in (1e-3, 5e-4, 2.5e-4, 1.25e-4)
        for run in [ancf.simulate(scene, 0.5, dt, integrator=KEEPS, tolerance=1e-9)]
    ]
    for k in range(2):
        if exact is None:
            errors = [np.abs(a[k] - b[k]).max() for a, b in pairwise(found)]
        else:
            errors = [np.abs(each[k] - exact[k]).max() for each in found]
        assert np.abs(orders(errors) - 2.0).max() < 0.15


def test_on_a_circle_positions_and_mean_multipliers_are_of_second_order():
    errors = []
    for dt in (0.02, 0.01, 0.005, 0.0025):
        n = round(1.0 / dt)
        q, _, _, lam, outcome = on_circle(1.0, 4.0).march(dt, n, KEEPS)
        assert outcome == Outcome.CONVERGED
        times = dt * np.arange(1, n + 1)
        where, _ = exact_circle(1.0, 4.0, times)
        # Of the middle of the step that ends at each time.
        _, pull = exact_circle(1.0, 4.0, times - dt / 2)
        off = np.abs(lam[:, 0] - pull)
        errors.append((np.abs(q - where).max(), off[:20].max(), off.max()))
    position, first, all_of_it = np.array(errors).T
    assert np.abs(orders(position) - 2.0).max() < 0.1
    assert np.abs(orders(all_of_it) - 2.0).max() < 0.1
    assert orders(first).min() > 1.8
    assert all_of_it[-1] < 1e-3  # of pulls of 10 to 30 N


@pytest.mark.parametrize("dt", [0.01, 0.05, 0.1, 0.2])
@pytest.mark.parametrize("stiffness", [1e6, 1e10])
def test_a_truss_keeps_its_energy_where_the_trapezoidal_rule_dies(stiffness, dt):
    point = truss(stiffness)
    q, v, _, _, outcome = point.march(dt, round(10.0 / dt), KEEPS)
    assert outcome == Outcome.CONVERGED
    energy = point.energy(q, v) / point.energy(point.q0[None], point.v0[None])[0]
    assert np.abs(energy - 1.0).max() < 1e-7
    spin = (q[:, 0] * v[:, 1] - q[:, 1] * v[:, 0]) / (point.q0[0] * point.v0[1])
    assert np.abs(spin - 1.0).max() < 1e-7


STEPS = {
    ("pendulum", 1e8): (5e-4, 2e-3, 1e-2),
    ("pendulum", 2.1e11): (5e-4, 2e-3, 1e-2, 2e-2),
    ("truss pendulum", 1e8): (2e-3, 2e-2),
    ("truss pendulum", 2.1e11): (2e-3, 2e-2),
    ("rod at the tip", 1e8): (5e-4, 2e-3, 1e-2),
    ("rod at the tip", 2.1e11): (5e-4, 2e-3, 1e-2, 2e-2),
}


@pytest.mark.parametrize(
    ("scene", "stiffness", "dt"), [(*key, dt) for key, steps in STEPS.items() for dt in steps]
)
def test_energy_stays_what_it_is(scene, stiffness, dt):
    steps = 4000 if dt < 1e-3 else 1000 if dt < 1e-2 else 150
    run = ancf.simulate(
        SCENES[scene](stiffness).scene, steps * dt, dt, integrator=KEEPS, tolerance=1e-5,
        solver=ancf.QuasiNewton("broyden", memory=10),
    )  # fmt: skip
    energy = run.energy
    off = (energy.total - energy.total[0]) / energy.kinetic.max()
    assert np.abs(off).max() < 2e-7
    # What a step may leave unbalanced, 1e-5 m/s2 of all masses, works over the way of the step.
    speed = np.sqrt(9.81 * 2.0)  # in the root mean square, of a rod of 2 m that has fallen
    assert np.abs(np.diff(off)).max() < 2e-9 + 2 * 1e-5 * dt / speed


def test_what_the_iteration_leaves_is_what_is_lost():
    off = []
    for tolerance in (1e-2, 1e-4, 1e-6):
        scene, _ = pendulum("thin", youngs_modulus=2.1e11)
        run = ancf.simulate(scene, 2.0, 2e-3, integrator=KEEPS, tolerance=tolerance)
        off.append(np.abs(run.energy.total - run.energy.total[0]).max())
    assert off[0] > 3.0 * off[1] > 9.0 * off[2]
    assert off[2] < 1e-8


BEAMS = {
    "l2t2": (2, "l2t2", {}),
    "thin": (2, "thin", {}),
    "biot": (2, "thin", {"strain": "biot"}),
    "thin, spatial": (3, "thin", {}),
    "biot, spatial": (3, "thin", {"strain": "biot"}),
    "thick, planar": (2, "thick", {"curvature": "section", "section_strain": "nodal"}),
    "thick": (3, "thick", {}),
}


def flying(name, dt, **options):
    """Free in space, turning, bent and stretched by its own inertia."""
    dim, element, how = BEAMS[name]
    scene = ancf.Scene((0.0,) * dim)

    def velocity(x):
        out = np.zeros_like(x)
        out[:, 0], out[:, 1] = 1.0 - 9.0 * x[:, 1], 2.0 + 9.0 * x[:, 0] ** 2
        if dim == 3:
            out[:, 2] = 3.0 * x[:, 0]
        return out

    material = ancf.Material(2e7, 2000.0, 0.3)
    scene.add_beam(element, (0.0,) * dim, (1.0, 0.3, 0.2)[:dim], 4, SECTION, material,
                   velocity=velocity, **how)  # fmt: skip
    return ancf.simulate(scene, 300 * dt, dt, **options)


def momenta(run):
    """Momentum (k, dim) and moment of momentum about the origin (k, 1 or 3)."""
    system, kind, dim = run.system, run.system.kinds[0], run.system.dim
    impulse = np.array([system.assembly.inertia(v) for v in run.v])
    vectors = {}
    for j, label in enumerate(kind.node_coordinates):
        vectors.setdefault(label[:-1], {})[int(label[-1]) - 1] = system.places[0][:, j]
    momentum = np.stack([impulse[:, vectors["r_"][d]].sum(axis=1) for d in range(dim)], axis=1)
    moment = np.zeros((len(run.t), 3))
    for places in vectors.values():
        arm, push = np.zeros((2, len(run.t), system.places[0].shape[0], 3))
        for d, where in places.items():
            arm[:, :, d], push[:, :, d] = run.q[:, where], impulse[:, where]
        moment += np.cross(arm, push).sum(axis=1)
    return momentum, moment if dim == 3 else moment[:, 2:]


@pytest.mark.parametrize("name", BEAMS)
def test_a_free_beam_keeps_energy_momentum_and_moment_of_momentum(name):
    run = flying(name, 2e-3, integrator=KEEPS, tolerance=1e-9)
    for values in momenta(run):
        assert np.abs(values - values[0]).max() < 1e-10 * np.abs(values).max()
    energy = run.energy
    assert np.abs(energy.total - energy.total[0]).max() < 1e-10 * energy.kinetic.max()
    assert energy.elastic.max() > 1e-3 * energy.kinetic.max()


def test_others_do_not():
    run = flying("thin", 2e-3, integrator=ancf.GeneralizedAlpha(0.9), tolerance=1e-9)
    _, moment = momenta(run)
    assert np.abs(moment - moment[0]).max() > 1e-5 * np.abs(moment).max()


class Step:
    """One step of two L2T2 elements, pinned, with the tip on a rod: dense, by quadrature.

    The strain of the axis is quadratic, so the discrete gradient of its energy is the integral of
    EA times its mean times its gradient in the middle.
    """

    length, anchor, reach = 0.5, np.array([1.0, 0.8]), 0.8

    def __init__(self, youngs_modulus, gravity):
        self.axial = youngs_modulus * SECTION.area
        self.bending = youngs_modulus * 0.01**4 / 12.0
        x, w = np.polynomial.legendre.leggauss(6)
        xi, self.w = (x + 1.0) / 2.0, w / 2.0 * self.length
        h = self.length
        one, none = np.ones_like(xi), np.zeros_like(xi)
        self.shape = np.array([1 - 3 * xi**2 + 2 * xi**3, h * (xi - 2 * xi**2 + xi**3),
                               3 * xi**2 - 2 * xi**3, h * (xi**3 - xi**2)])  # fmt: skip
        self.slope = np.array([-6 * xi + 6 * xi**2, h * (1 - 4 * xi + 3 * xi**2),
                               6 * xi - 6 * xi**2, h * (3 * xi**2 - 2 * xi)]) / h  # fmt: skip
        self.bend = np.array([-6 * one + 12 * xi, h * (-4 * one + 6 * xi), 6 * one - 12 * xi,
                              h * (6 * xi - 2 * one)]) / h**2 + none  # fmt: skip
        density = 2000.0 * SECTION.area
        self.mass = np.zeros((6, 6))
        for e in range(2):
            part = slice(2 * e, 2 * e + 4)
            self.mass[part, part] += density * np.einsum(
                "iq,jq,q->ij", self.shape, self.shape, self.w
            )
        self.weight = self.mass @ np.array([1.0, 0.0] * 3)[:, None] * gravity

    def elastic(self, q0, q1):
        """Force on rows (6, 2): positions and slopes of three nodes."""
        out, middle = np.zeros((6, 2)), 0.5 * (q0 + q1)
        for e in range(2):
            part = slice(2 * e, 2 * e + 4)
            strain = [0.5 * ((self.slope.T @ q[part]) ** 2).sum(axis=1) - 0.5 for q in (q0, q1)]
            tension = self.axial * 0.5 * (strain[0] + strain[1]) * self.w
            out[part] += self.slope @ (tension[:, None] * (self.slope.T @ middle[part]))
            out[part] += self.bend @ (self.bending * self.w[:, None] * (self.bend.T @ middle[part]))
        return out

    def solve(self, q0, v0, dt):
        """Return q1, v1 and the multiplier."""
        free = slice(1, None)  # of the first node only the slope

        def unpack(x):
            q1 = q0.copy()
            q1[free] = q0[free] + 1e-3 * x[:10].reshape(5, 2)
            return q1, 1e3 * x[10]

        def off(x):
            q1, lam = unpack(x)
            v1 = 2.0 * (q1 - q0) / dt - v0
            r = self.mass @ (v1 - v0) / dt + self.elastic(q0, q1) - self.weight
            r[4] += lam * (0.5 * (q0[4] + q1[4]) - self.anchor) / self.reach
            phi = ((q1[4] - self.anchor) ** 2).sum() - self.reach**2
            return np.append(r[free].ravel(), 1e6 * phi)

        found = root(off, np.zeros(11), method="hybr", options={"xtol": 1e-14})
        assert np.abs(found.fun).max() < 1e-6
        q1, lam = unpack(found.x)
        return q1, 2.0 * (q1 - q0) / dt - v0, lam


def test_one_step_is_that_of_a_dense_solver():
    gravity = np.array([0.3, -9.81])
    scene = ancf.Scene(tuple(gravity))
    rod = scene.add_beam(
        "l2t2", (0, 0), (1, 0), 2, SECTION, ancf.Material(1e8, 2000.0),
        velocity=lambda x: np.stack([-2.0 * x[:, 0] * (1 - x[:, 0]), 0.0 * x[:, 0]], axis=1),
    )  # fmt: skip
    scene.pin(rod.start)
    scene.rod(rod.end, Step.anchor)
    dt = 2e-3
    run = ancf.simulate(scene, 5 * dt, dt, integrator=KEEPS, tolerance=1e-9, solver=ancf.Newton())
    rows = run.system.places[0].reshape(6, 2)
    step = Step(1e8, gravity)
    for k in range(1, 5):  # the first step starts from a velocity of its own
        q1, v1, lam = step.solve(run.q[k][rows], run.v[k][rows], dt)
        np.testing.assert_allclose(run.q[k + 1][rows], q1, rtol=0, atol=1e-12)
        np.testing.assert_allclose(run.v[k + 1][rows], v1, rtol=0, atol=1e-9)
        assert run.multipliers[k + 1, 0] == pytest.approx(lam, abs=1e-5 * abs(lam) + 1e-6)
    assert np.abs(run.q[-1] - run.q[0]).max() > 1e-4
    assert np.abs(run.multipliers).max() > 0.1  # of a weight of 2 N


def test_damping_takes_what_it_takes_in_the_middle_of_each_step():
    scene = ancf.Scene((0.0, -9.81))
    material = ancf.Material(
        1e8, 4000.0, bending_damping=1e-2, axial_damping=1e-3, rayleigh=(0.1, 0)
    )
    rod = scene.add_beam("thin", (0, 0), (2, 0), 6, SECTION, material)
    scene.pin(rod.start)
    dt = 1e-3
    run = ancf.simulate(scene, 0.5, dt, integrator=KEEPS, tolerance=1e-8)
    energy, assembly = run.energy, run.system.assembly
    taken = []
    for k in range(1, len(run.t)):
        v = (run.q[k] - run.q[k - 1]) / dt
        taken.append(dt * v @ assembly.damping(0.5 * (run.q[k] + run.q[k - 1]), v))
    change = np.diff(energy.kinetic + energy.elastic + energy.potential)
    assert np.abs(change + taken).max() < 1e-10 * energy.kinetic.max()
    assert max(change) < 0.0
    assert sum(taken) > 1e-2 * energy.kinetic.max()


def test_loads_that_change_do_the_work_of_their_mean():
    scene, rod = pendulum("thin", 6)
    scene.point_force(rod.end, lambda t: (np.sin(9.0 * t), 2.0 * t))
    run = ancf.simulate(scene, 0.5, 1e-3, integrator=KEEPS, tolerance=1e-8, max_energy_gain=1e-9)
    force = np.stack([np.sin(9.0 * run.t), 2.0 * run.t], axis=1)
    way = np.diff(run.position(rod.end), axis=0)
    work = np.sum(0.5 * (force[1:] + force[:-1]) * way, axis=1)
    energy = run.energy
    change = np.diff(energy.kinetic + energy.elastic + energy.potential)
    assert np.abs(change - work).max() < 1e-9 * energy.kinetic.max()
    assert np.abs(work.sum()) > 1e-2


@pytest.mark.parametrize("scene", ["pendulum", "rod at the tip"])
def test_the_matrix_of_a_step_is_the_derivative_of_its_residual_for_short_steps(scene):
    off = []
    for dt in (1e-3, 1e-4, 1e-5):
        system = System(SCENES[scene](1e8).scene)
        march, *_ = prepare_implicit(system, dt, KEEPS, Newton(), "default", np.inf)
        exact, _ = finite_difference(march)
        found = full(system, march.matrix())
        n = system.n_free
        for block in (exact, found):
            block[n:, n:] = 0.0  # a small number keeps the factor definite
        off.append(np.abs(found - exact).max() / np.abs(exact).max())
    assert off[0] < 1e-2
    assert off[1] < 1e-4
    assert off[2] < 1e-5


def test_a_system_that_is_shared_among_threads_moves_the_same():
    found = []
    for threads in (1, 2):
        scene, rod = chain(12_000, "rough")
        run = ancf.simulate(scene, 3e-3, 5e-4, integrator=KEEPS, threads=threads,
                            save_nodes=[rod.at(0.4), rod.end])  # fmt: skip
        assert run.stats.threads == threads
        found.append(np.array([run.position(rod.at(0.4)), run.position(rod.end)]))
    assert np.abs(found[0] - found[1]).max() < 1e-9


def test_halved_steps_keep_the_energy_too():
    scene, _ = pendulum("thin")
    few = ancf.Newton(max_iterations=3)
    run = ancf.simulate(scene, 0.8, 1e-2, integrator=KEEPS, solver=few, tolerance=1e-6,
                        max_halvings=5)  # fmt: skip
    assert any("steps of" in event.rung for event in run.stats.events)
    energy = run.energy
    assert np.abs(energy.total - energy.total[0]).max() < 1e-6 * energy.kinetic.max()


@pytest.mark.parametrize("accuracy", [1e-3, 1e-5])
def test_an_accuracy_is_met(accuracy):
    scene, rod = pendulum("thin")
    run = ancf.simulate(scene, 0.5, 0.01, accuracy=accuracy, integrator=KEEPS)
    fine = ancf.simulate(scene, 0.5, 0.01, accuracy=1e-8, integrator=ancf.RungeKuttaNystrom(8))
    error = np.abs(run.position(rod.end) - fine.position(rod.end)).max()
    assert 1e-3 * accuracy < error < accuracy


def test_no_rare_step_is_accepted_with_a_residual_that_does_work():
    # One correction in some ten thousand leads kilometres away and back.
    path = ancf.simulate(pendulum("thin").scene, 74.0, 2e-3, integrator=ancf.EnergyMomentum())
    change = np.abs(np.diff(path.energy.total)) / path.energy.kinetic.max()
    assert change.max() < 1e-7


@pytest.mark.parametrize("integrator", [KEEPS, ancf.GeneralizedAlpha(0.8)], ids=repr)
def test_the_definite_neighbour_of_a_matrix_is_the_matrix_where_nothing_is_stressed(integrator):
    values = []
    for damping in (1e-3, 0.0):
        scene = ancf.Scene((0.0, 0.0))
        material = ancf.Material(1e8, 4000.0, axial_damping=damping, bending_damping=damping)
        rod = scene.add_beam("thin", (0, 0), (2, 0), 6, SECTION, material)
        scene.pin(rod.start)
        march, *_ = prepare_implicit(System(scene), 1e-3, integrator, "auto", "default", np.inf)
        values.append(march.matrix())
        atol = 1e-12 * np.abs(march.matrix()).max()
        np.testing.assert_allclose(march.material(), march.matrix(), rtol=1e-9, atol=atol)
    # Half of the damping would show.
    assert np.abs(values[0] - values[1]).max() > 0.1 * np.abs(values[1]).max()
