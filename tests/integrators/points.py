"""A mass point as a system for the compiled march: `ancf_system` through ctypes.

Bodies of one point have motions that are known to many digits, and nothing but time to get wrong.
"""

from types import SimpleNamespace

import numpy as np
import scipy.sparse as sp
from scipy.integrate import solve_ivp

import ancfsparse as ancf
from ancfsparse.integrators.implicit.time_integration import make_time_loop
from ancfsparse.nonlinear import Newton
from ancfsparse.nonlinear.iteration import Costs, make_inverse, make_iteration
from ancfsparse.nonlinear.loop_protocols import Tolerance
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.initial_conditions.consistent_state import starting_state
from ancfsparse.system import System
from ancfsparse.system.coordinates.prescribed_motion import PrescribedMotions
from tests.headers import implement


class Point:
    """A point in the plane, on a circle about the origin or on a spring of Green's strain.

    Parameters
    ----------
    mass, gravity : float
        Mass [kg]; weight per mass in -y [m/s2].
    q, v : (2,) float
        Start [m], [m/s].
    radius : float, optional
        Of the circle ``(x^2 + y^2 - radius^2) / (2 radius) = 0`` [m].
    stiffness, length : float, optional
        EA [N] and L [m] of the spring, energy ``EA L e^2 / 2`` with
        ``e = ((x^2 + y^2) / L^2 - 1) / 2``.
    """

    damped = depends_on_reactions = False
    n_history, history = 0, np.zeros(0)

    def __init__(self, q, v, mass=1.0, gravity=9.81, radius=None, stiffness=0.0, length=1.0):
        self.mass, self.radius, self.stiffness, self.length = mass, radius, stiffness, length
        self.n_free = self.n_all = 2
        self.n_multipliers = 0 if radius is None else 1
        self.is_redundant = False
        self.q0, self.v0 = np.array(q, dtype=float), np.array(v, dtype=float)
        self.t0, self.q_ref = 0.0, self.q0
        self.dead_load = np.array([0.0, -mass * gravity])
        n = 2 + self.n_multipliers
        row, column = np.tril_indices(n)
        order = np.lexsort((row, column))
        self._row, self._column = row[order], column[order]
        self.indptr = np.searchsorted(self._column, np.arange(n + 1))
        self.interface, self.capsule = implement(
            "ancf_system", n_free=2, n_all=2, n_multipliers=self.n_multipliers, n_values=len(row),
            residual=self._residual, matrix=self._matrix, material=self._material,
            inertia=self._inertia, energies=self._energies, load_work=lambda *_: 0.0,
            residual_between=self._residual_between, add=self._add,
        )  # fmt: skip
        # What the start and the set-up of a run ask of a system.
        self.dim, self.positions = 2, np.arange(2)
        # A body without length: what sizes are compared with is where the point is.
        self.scene = SimpleNamespace(bodies=[SimpleNamespace(shortest=0.0)])
        self.mass_diagonal = np.full(2, mass)
        self.pattern = SimpleNamespace(indptr=self.indptr, indices=self._row.astype(np.int32))
        self.assembly, self.contributions = self, []
        self.prescribed = PrescribedMotions([], [])
        self.inputs = lambda times: (np.zeros((len(times), 0)), None)
        self.loads = SimpleNamespace(
            n_amplitudes=0, amplitudes=lambda times: np.zeros((len(times), 0))
        )
        self.constraints = SimpleNamespace(
            jacobian=lambda q: sp.csr_array(self.gradient(q)),
            linear=radius is None,
            sizes=lambda q: np.abs(self.gradient(q)) @ np.abs(q),
            measures=[],
            curvature=lambda q, v: np.array([v @ v / radius] if radius else []),
        )

    largest_length = System.largest_length

    def seed(self):
        return SparseSeed(self.indptr, self._row.astype(np.int32), 2)

    def use_couplings(self, value):
        """Have no elements to couple."""

    def reset_memory(self):
        """Have nothing to forget: what it is depends on its state alone."""

    def gradient(self, q):
        """phi_q, shape (m, 2)."""
        return (q / self.radius)[None] if self.radius else np.zeros((0, 2))

    def force(self, q):
        e = (q @ q / self.length**2 - 1.0) / 2.0
        return self.stiffness * e / self.length * q

    def energies(self, q, v):
        return np.zeros((3, len(q)))

    def stiffness_diagonal(self, q):
        return np.full(2, self.mass * 10.0)

    def operations(self, kernel):
        return 10

    def set_regularization(self, value):
        pass  # there is a fixed one

    def inertia(self, a):
        return self.mass * a

    def residual(self, q, v, a, lam, dead_load, amplitudes):
        r = self.mass * a + self.force(q) - dead_load + self.gradient(q).T @ lam
        return r, np.array([(q @ q / self.radius - self.radius) / 2.0] if self.radius else [])

    def matrix(
        self, mass_factor, stiffness_factor, q, lam, amplitudes, *, damping_factor=0.0, v=None
    ):
        e = (q @ q / self.length**2 - 1.0) / 2.0
        k = self.stiffness * e / self.length * np.eye(2)
        if self.radius:
            k += lam[0] / self.radius * np.eye(2)
        return self.material(mass_factor, stiffness_factor, q, k)

    def material(self, mass_factor, stiffness_factor, q, rest=0.0):
        k = self.stiffness * np.outer(q, q) / self.length**3 + rest
        out = np.zeros((2 + self.n_multipliers,) * 2)
        out[:2, :2] = mass_factor * self.mass * np.eye(2) + stiffness_factor * k
        out[2:, :2] = self.gradient(q)
        out[2:, 2:] = -1e-14
        return out[self._row, self._column]

    def _residual(self, _, q, v, a, lam, dead_load, amplitudes, r, phi):
        q, a, dead_load = (np.ctypeslib.as_array(x, (2,)) for x in (q, a, dead_load))
        lam = np.ctypeslib.as_array(lam, (1,))[: self.n_multipliers]
        with np.errstate(all="ignore"):
            force, off = self.residual(q, None, a, lam, dead_load, None)
        np.ctypeslib.as_array(r, (2,))[:] = force
        if self.radius:
            phi[0] = off[0]

    def _residual_between(self, _, q0, q1, q, v, a, lam, dead_load, amplitudes, r, phi):
        q0, q1, a, load = (np.ctypeslib.as_array(x, (2,)) for x in (q0, q1, a, dead_load))
        lam = np.ctypeslib.as_array(lam, (1,))[: self.n_multipliers]
        middle = 0.5 * (q0 + q1)
        # The mean strain, and its gradient in the middle, where a quadratic function has the slope
        # of its chord.
        e = ((q0 @ q0 + q1 @ q1) / self.length**2 / 2.0 - 1.0) / 2.0
        force = self.stiffness * e / self.length * middle
        r = np.ctypeslib.as_array(r, (2,))
        r[:] = self.mass * a + force - load + self.gradient(middle).T @ lam
        if self.radius:
            phi[0] = (q1 @ q1 / self.radius - self.radius) / 2.0

    def _matrix(self, _, mass_factor, stiffness_factor, damping, q, v, lam, amplitudes, values):
        q, lam = np.ctypeslib.as_array(q, (2,)), np.ctypeslib.as_array(lam, (1,))
        with np.errstate(all="ignore"):
            found = self.matrix(mass_factor, stiffness_factor, q, lam, None)
        np.ctypeslib.as_array(values, (len(found),))[:] = found

    def _material(self, _, mass_factor, stiffness_factor, damping, q, values):
        found = self.material(mass_factor, stiffness_factor, np.ctypeslib.as_array(q, (2,)))
        np.ctypeslib.as_array(values, (len(found),))[:] = found

    def _add(self, _, factor, more, values):
        more, values = (np.ctypeslib.as_array(x, (len(self._row),)) for x in (more, values))
        values += factor * more

    def _inertia(self, _, a, out):
        out[0], out[1] = self.mass * a[0], self.mass * a[1]

    def _energies(self, _, q, v, amplitudes, scratch, out):
        q, v = np.ctypeslib.as_array(q, (2,)), np.ctypeslib.as_array(v, (2,))
        out[0], out[1] = 0.5 * self.mass * (v @ v), self.strain_energy(q)

    def strain_energy(self, q):
        e = (q @ q / self.length**2 - 1.0) / 2.0
        return 0.5 * self.stiffness * self.length * e**2

    def energy(self, q, v):
        """Energy of states (k, 2) [J]."""
        strain = np.array([self.strain_energy(row) for row in q])
        return 0.5 * self.mass * np.sum(v**2, axis=1) + strain - q @ self.dead_load

    def march(
        self, dt, n_steps, integrator, corrected=True, start=None, largest_gain=np.inf, solver=None
    ):
        """States after each step, the outcome: ``q, v, a (k, 2), lam (k, m), outcome``.

        Without correction the march starts from the true velocity and acceleration.
        """
        seed = self.seed()
        begin, _ = starting_state(self, seed, integrator, dt)
        if not corrected:
            begin = type(begin)(self.q0, self.v0, begin.a, begin.a, begin.lam, np.zeros(0))
        if start is not None:
            begin = start(begin)
        march = make_time_loop(self, dt, integrator, begin, largest_gain, 0.0, 0.0)
        scale = integrator.scale * dt**2
        tolerance = Tolerance(False, scale * 1e-9 * (1 + self.stiffness * 1e-4), 1e-14, 0.0, 1e-16)
        march.prepare(np.zeros((1, 0)))
        solver = solver or Newton()
        loop = make_iteration(
            march, seed, make_inverse(solver, seed, None, np.ones(seed.n), 0.0), solver,
            tolerance, Costs(1.0, 0.0, 1.0),
        )  # fmt: skip
        self.loop, self.marched = loop, march
        out = [np.zeros((n_steps + 1, 2)) for _ in range(3)]
        out.append(np.zeros((n_steps + 1, self.n_multipliers)))
        taken, outcome = march.advance(loop, n_steps, np.zeros((n_steps, 0)), 1, 0, *out)
        return *(table[1 : taken + 1] for table in out), outcome


def bar_by_hand(point, integrator, dt, n, a, b):
    """Places and velocities (n, 2) of a bar worked out by hand, from its first accelerations a, b.

    The new place is along the sum of all that is known: ``q (1 + k e(q)) = known`` with
    ``k = scale EA / (m L)`` is a cubic equation for the length; its largest root is the bar that
    turns without turning over.
    """
    q, v, length = point.q0, point.v0, point.length
    m, f, beta, gamma = (getattr(integrator, x) for x in ("alpha_m", "alpha_f", "beta", "gamma"))
    scale = integrator.scale * dt**2
    k = scale * point.stiffness / (point.mass * length)
    places, velocities = [], []
    for _ in range(n):
        rest = (f * a - m * b) / (1.0 - m)
        known = q + dt * v + dt**2 * ((0.5 - beta) * b + beta * rest)
        size = np.linalg.norm(known)
        roots = np.roots([0.5 * k / length**2, 0.0, 1.0 - 0.5 * k, -size])
        q = max(roots.real[np.abs(roots.imag) < 1e-9]) / size * known
        a = (q - known) / scale
        new = rest + (1.0 - f) / (1.0 - m) * a
        v = v + dt * ((1.0 - gamma) * b + gamma * new)
        b = new
        places.append(q)
        velocities.append(v)
    return np.array(places), np.array(velocities)


def on_circle(angle, speed, gravity=9.81):
    """A pendulum of 1 m and 1 kg, the angle from straight down [rad], turning at speed [rad/s]."""
    q = np.array([np.sin(angle), -np.cos(angle)])
    return Point(q, speed * np.array([np.cos(angle), np.sin(angle)]), gravity=gravity, radius=1.0)


def exact_circle(angle, speed, times, gravity=9.81):
    """Position (k, 2) [m] and multiplier (k,) [N] of that pendulum."""
    found = solve_ivp(
        lambda t, y: [y[1], -gravity * np.sin(y[0])], (0.0, times[-1]), [angle, speed],
        method="DOP853", t_eval=times, rtol=1e-13, atol=1e-13,
    )  # fmt: skip
    theta, rate = found.y
    # phi_q has length one and points outwards: the multiplier is the pull of the rod.
    return np.stack([np.sin(theta), -np.cos(theta)], axis=1), rate**2 + gravity * np.cos(theta)


def orders(errors):
    """Return the orders of convergence between errors of steps that are halved."""
    return np.log2(np.array(errors[:-1]) / errors[1:])


def assert_saved_seldom(scene, strides, **options):
    """Assert that a run of more than one chunk of steps saves the states of one that saves all."""
    every = ancf.simulate(scene, 2.1, 5e-4, **options)
    assert len(every.t) == 4201
    for stride in strides:
        some = ancf.simulate(scene, 2.1, 5e-4, save_every=stride, **options)
        rows = [*range(0, 4201, stride)]
        rows += [4200] * (rows[-1] != 4200)  # the last state is saved in any case
        for name in ("q", "v", "a", "t"):
            np.testing.assert_array_equal(getattr(some, name), getattr(every, name)[rows])
