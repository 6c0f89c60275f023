"""Residuals weighted by adjoint solutions, a prototype: what plans would gain by them.

``python tests/plans/adjoints.py`` prints the estimates of dual-weighted residuals (Becker and
Rannacher 2001; of models Braack and Ern 2003) beside the errors of pilots and the estimates by two
meshes and halved steps, with their counted work.  docs/model.md has the conclusions.
"""

from functools import cached_property

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

import ancfsparse as ancf
from ancfsparse.plans.models.prolongation import prolonged
from ancfsparse.plans.trial_runs.cost_model import BESIDE, FACTOR, RESIDUAL, SOLVE, counted
from ancfsparse.system import System

RHO = 0.9
# Generalized alpha of Arnold and Bruels (2007), by its spectral radius.
ALPHA_M, ALPHA_F = (2.0 * RHO - 1.0) / (RHO + 1.0), RHO / (RHO + 1.0)
GAMMA = 0.5 + ALPHA_F - ALPHA_M
BETA = 0.25 * (0.5 + GAMMA) ** 2
SHARE = (1.0 - ALPHA_F) / (1.0 - ALPHA_M)
SHEARED = {"curvature": "section", "section_strain": "nodal"}


def matrix(system, values):
    """Return the free part of a symmetric matrix from its lower triangle, dense."""
    pattern, n = system.pattern, system.n_free
    count = len(pattern.indptr) - 1
    own = np.asarray(values)[: len(pattern.indices)]
    lower = sp.tril(sp.csc_array((own, pattern.indices, pattern.indptr), shape=(count, count)))
    whole = (lower + lower.T - sp.diags_array(lower.diagonal())).toarray()
    return whole[:n, :n]


def stiffness(system, q, t=0.0):
    amplitudes = system.loads.amplitudes(np.array([t]))[0]
    lam = np.zeros(system.n_multipliers)
    return matrix(system, system.assembly.matrix(0.0, 1.0, q, lam, amplitudes))


def residual(system, q, v=None, a=None, t=0.0):
    amplitudes = system.loads.amplitudes(np.array([t]))[0]
    rest, lam = np.zeros_like(q), np.zeros(system.n_multipliers)
    v, a = (rest if each is None else np.ascontiguousarray(each) for each in (v, a))
    q = np.ascontiguousarray(q)
    out = system.assembly.residual(q, v, a, lam, system.dead_load, amplitudes)[0]
    return np.array(out)[: system.n_free]


def gradient(system, node):
    """Return the derivative of a position by the free coordinates, (dim, n_free)."""
    places, weights = system.point(node)
    out = np.zeros((len(places), len(system.q_ref)))
    for row, own in zip(out, places, strict=True):
        np.add.at(row, own, weights)
    return out[:, : system.n_free]


def on_finer(coarse, table, system):
    """Return a table of coordinates (k, n_all), or of their rates, on another mesh."""
    out = np.empty((len(table), len(system.q_ref)))
    for row, own in zip(out, np.asarray(table), strict=True):
        state = prolonged(_Only(coarse, own[None]), system.scene)
        for mine, its in zip(system.places, state.layout.places, strict=True):
            row[mine] = state.q[its]
    return out


class _Only:
    """What `prolonged` reads of a run."""

    def __init__(self, system, q):
        self.system, self.q, self.t = system, q, np.zeros(1)


def halved(run):
    """Return times and states of a run with the middle of every step, by quintics."""
    q, v, a = (np.asarray(x) for x in (run.q, run.v, run.a))
    h = run.t[1] - run.t[0]
    middle = (
        0.5 * (q[:-1] + q[1:]) + 5 / 32 * h * (v[:-1] - v[1:]) + h * h / 64 * (a[:-1] + a[1:]),
        15 / 8 * (q[1:] - q[:-1]) / h - 7 / 16 * (v[:-1] + v[1:]) + h / 32 * (a[:-1] - a[1:]),
        1.5 * (v[1:] - v[:-1]) / h - 0.25 * (a[:-1] + a[1:]),
    )
    states = []
    for own, between in zip((q, v, a), middle, strict=True):
        states.append(np.empty((2 * len(own) - 1, own.shape[1])))
        states[-1][::2], states[-1][1::2] = own, between
    return np.linspace(run.t[0], run.t[-1], 2 * len(run.t) - 1), states


class Linearised:
    """Steps of generalized alpha about given states, and by how much these violate them."""

    def __init__(self, system, t, states):
        n = self.n = system.n_free
        self.system, self.t, self.h = system, t, t[1] - t[0]
        q, v, a = (np.array(x) for x in states)
        q[:, n:], v[:, n:], a[:, n:] = system.q_ref[n:], 0.0, 0.0
        self.q = q
        h, b = self.h, np.zeros((len(t), n))
        b[0] = a[0, :n]
        self.r, self.dq, self.dv = np.zeros((3, len(t), n))
        for i in range(1, len(t)):
            b[i] = (ALPHA_F * a[i - 1, :n] - ALPHA_M * b[i - 1]) / (1 - ALPHA_M) + SHARE * a[i, :n]
            went = h * v[i - 1, :n] + h * h * ((0.5 - BETA) * b[i - 1] + BETA * b[i])
            self.dq[i] = q[i, :n] - q[i - 1, :n] - went
            sped = h * ((1.0 - GAMMA) * b[i - 1] + GAMMA * b[i])
            self.dv[i] = v[i, :n] - v[i - 1, :n] - sped
            self.r[i] = residual(system, q[i], v[i], a[i], t[i])

    @cached_property
    def matrices(self):
        """Stiffness and factor of the matrix of every step."""
        mass = matrix(self.system, self.system.assembly.mass)
        out = [None]
        for q, t in zip(self.q[1:], self.t[1:], strict=True):
            own = stiffness(self.system, q, t)
            out.append((own, la.lu_factor(mass + self.h**2 * BETA * SHARE * own)))
        return out

    def tangent(self):
        """Return by how much the solution of the steps differs from the states, (k, n)."""
        h, (dq, dv, da, db) = self.h, np.zeros((4, self.n))
        out = [dq]
        for i in range(1, len(self.t)):
            own, factor = self.matrices[i]
            new = (ALPHA_F * da - ALPHA_M * db) / (1.0 - ALPHA_M)
            dq = dq + h * dv + h * h * ((0.5 - BETA) * db + BETA * new) - self.dq[i]
            dv = dv + h * ((1.0 - GAMMA) * db + GAMMA * new) - self.dv[i]
            da = la.lu_solve(factor, -own @ dq - self.r[i])
            db = new + SHARE * da
            dq = dq + h * h * BETA * SHARE * da
            dv = dv + h * GAMMA * SHARE * da
            out.append(dq)
        return np.array(out)

    def adjoint(self, goal):
        """Return by how much a goal at the end differs, by its sensitivity, which is how large.

        Parameters
        ----------
        goal : ndarray, shape (n,)
            Derivative of the goal by the last coordinates.

        Returns
        -------
        float
            The difference.
        float
            Largest derivative by the coordinates of a step over those of the last.
        """
        h, (zv, za, zb) = self.h, np.zeros((3, self.n))
        zq, out, largest = goal.copy(), 0.0, 0.0
        for i in range(len(self.t) - 1, 0, -1):
            own, factor = self.matrices[i]
            force = za + h * h * BETA * SHARE * zq + h * GAMMA * SHARE * zv + SHARE * zb
            w = la.lu_solve(factor, force, trans=1)
            zq = zq - own.T @ w
            out -= w @ self.r[i] + zq @ self.dq[i] + zv @ self.dv[i]
            new = zb + h * h * BETA * zq + h * GAMMA * zv
            zb = h * h * (0.5 - BETA) * zq + h * (1.0 - GAMMA) * zv
            zb = zb - ALPHA_M / (1.0 - ALPHA_M) * new
            za = ALPHA_F / (1.0 - ALPHA_M) * new
            zv = zv + h * zq
            largest = max(largest, float(np.abs(zq).max()))
        return out, largest / float(np.abs(goal).max())

    @property
    def work(self):
        """Counted work: a residual, a factor and a solution for every step."""
        return (len(self.t) - 1) * (RESIDUAL + FACTOR + SOLVE) * (self.n + BESIDE)


def beam(element, n, section, material, end=(1.0, 0.0), gravity=-9.81, **options):
    scene = ancf.Scene((0.0, gravity))
    return scene, scene.add_beam(element, (0.0, 0.0), end, n, section, material, **options)


def pendulum(n):
    scene, rod = beam("thin", n, ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4e3), (2.0, 0.0))
    scene.pin(rod.start)
    return scene, rod.end


def cantilever(n):
    made = ancf.Rectangle(0.01, 0.01), ancf.Material(2e9, 1e3)
    scene, rod = beam("thin", n, *made, gravity=0.0)
    scene.clamp(rod.start)
    scene.point_force(rod.end, ancf.Ramp((0.0, -2.0), 0.3, smooth=True))
    return scene, rod.end


def taut(n):
    scene, rod = beam("thin", n, ancf.Circle(0.002), ancf.Material(1e9, 1e3), tension=20.0)
    scene.pin(rod.start)
    scene.pin(rod.end)
    middle = rod.at(0.5 * rod.length)
    scene.point_force(middle, ancf.Ramp((0.0, -1.0), 0.05, smooth=True))
    return scene, middle


def steel(n):
    made = ancf.Rectangle(0.01, 0.01), ancf.Material(2.1e11, 7850.0)
    scene, rod = beam("thin", n, *made, (2.0, 0.0))
    scene.pin(rod.start)
    return scene, rod.end


def double(n):
    """Double pendulum of stiff rods that starts nearly upright."""
    made = ancf.Rectangle(0.03, 0.03), ancf.Material(1e10, 1e3)
    elbow = (0.3, 0.954)
    scene, arm = beam("thin", n, *made, elbow)
    other = scene.add_beam("thin", elbow, (0.4, 1.949), n, *made)
    scene.pin(arm.start)
    scene.connect(arm.end, other.start)
    return scene, other.end


def droop(n):
    scene, rod = beam("thin", n, ancf.Circle(0.01), ancf.Material(1e7, 1e3))
    scene.clamp(rod.start)
    return scene, rod.end


def sagging(n):
    scene, rod = beam("thin", n, ancf.Circle(0.01), ancf.Material(1e7, 1e3), length=1.1)
    scene.pin(rod.start)
    scene.pin(rod.end)
    return scene, rod.at(0.4)


def clamped(n):
    scene, rod = beam("thin", n, ancf.Rectangle(0.01, 0.01), ancf.Material(2e9, 1e3))
    scene.clamp(rod.start)
    scene.clamp(rod.end)
    scene.distributed_force(rod, (0.0, -100.0))
    return scene, rod.at(0.5)


MOTIONS = {
    "pendulum, 0.5 s": (pendulum, 0.5, 8, 100),
    "pendulum, 2 s": (pendulum, 2.0, 8, 400),
    "cantilever, 0.5 s": (cantilever, 0.5, 8, 200),
    "taut line, 0.1 s": (taut, 0.1, 8, 100),
    "steel pendulum, 1 s": (steel, 1.0, 8, 200),
}
STATICS = {"drooping rod": droop, "sagging line": sagging, "clamped beam": clamped}


def marched(make, n, t_end, steps):
    scene, node = make(n)
    integrator = ancf.GeneralizedAlpha(RHO)
    return ancf.simulate(scene, t_end, t_end / steps, integrator=integrator), node


def work(run):
    return counted(run.stats, len(run.t) - 1, run.q.shape[1]).amount


def of_motion(make, t_end, n, steps):
    """Return errors at the end, true, by adjoints, and by the finer pilot, with the work of both.

    For the mesh and for the steps a tuple each; and by how much sensitivities grow, and the size of
    the motion [m].
    """
    run, node = marched(make, n, t_end, steps)
    own = run.position(node)

    def apart(n, steps):
        other, its = marched(make, n, t_end, steps)
        return other.position(its)[-1] - own[-1], other

    scene, its = make(2 * n)
    system = System(scene)
    states = [on_finer(run.system, each, system) for each in (run.q, run.v, run.a)]
    finer = Linearised(system, run.t, states)
    by_finer = np.array([finer.adjoint(goal)[0] for goal in gradient(system, its)])
    shorter = Linearised(run.system, *halved(run))
    swept = [shorter.adjoint(goal) for goal in gradient(run.system, node)]
    by_shorter = np.array([each[0] for each in swept])
    second, its_run = apart(3 * n // 2, steps)
    half, half_run = apart(n, 2 * steps)
    mesh = apart(4 * n, steps)[0], by_finer / (1.0 - 2.0**-4), second / (1.0 - 1.5**-4)
    time = apart(n, 8 * steps)[0], by_shorter / (1.0 - 2.0**-2), half / (1.0 - 2.0**-2)
    return (
        (*map(np.linalg.norm, mesh), finer.work, work(its_run)),
        (*map(np.linalg.norm, time), shorter.work, work(half_run)),
        max(each[1] for each in swept),
        float(np.linalg.norm(own - own[0], axis=1).max()),
    )


def has_blown_up(estimate, size):
    """Whether the error is no perturbation any more: larger than the motion itself."""
    return not estimate <= size


def of_equilibrium(make, n):
    """Return errors, true, by the adjoint, and by the finer pilot, with the work of both."""
    found = {}
    for count in (n, 3 * n // 2, 16 * n):
        scene, node = make(count)
        first = next(iter(found.values()), None)
        start = first and prolonged(_Only(first[0].system, first[0].q[None]), scene)
        equilibrium = ancf.solve_static(scene, start=start)
        found[count] = equilibrium, equilibrium.position(node)
    own, place = found[n]
    scene, node = make(2 * n)
    system = System(scene)
    (q,) = on_finer(own.system, own.q[None], system)
    z = np.linalg.solve(stiffness(system, q), gradient(system, node).T)
    by_adjoint = -(z.T @ residual(system, q)) / (1.0 - 2.0**-4)
    second, other = found[3 * n // 2][0], found[3 * n // 2][1] - place
    errors = found[16 * n][1] - place, by_adjoint, other / (1.0 - 1.5**-4)
    spent = (RESIDUAL + FACTOR + SOLVE) * (system.n_free + BESIDE)
    count = second.system.n_free
    return (*map(np.linalg.norm, errors), spent, counted(second.stats, 1, count).amount)


def of_shear(height, n):
    """Return by how much shear bends a cantilever on, truly and by the residual of thick beams."""
    force = -0.15 * 1e8 * height**4 / 12.0

    def made(element, n, **options):
        section = ancf.Rectangle(height, height)
        scene, rod = beam(element, n, section, ancf.Material(1e8, 1e3, 0.3), gravity=0.0, **options)
        scene.clamp(rod.start)
        scene.point_force(rod.end, (0.0, force))
        return scene, rod

    ends = []
    for each in (made("thin", 64), made("thick", 512, **SHEARED)):
        ends.append(ancf.solve_static(each[0]).position(each[1].end))
    cable = ancf.solve_static(made("thin", n)[0])
    scene, rod = made("thick", n, **SHEARED)
    system = System(scene)
    q = system.q_ref.copy()
    for name in ("r", "r_x"):
        q[system.vectors(name)[0]] = cable.q[cable.system.vectors(name)[0]]
    slopes = q[system.vectors("r_x")[0]]
    across = np.stack([-slopes[:, 1], slopes[:, 0]], axis=1)
    q[system.vectors("r_y")[0]] = across / np.linalg.norm(slopes, axis=1)[:, None]
    q[system.n_free :] = system.q_ref[system.n_free :]
    z = np.linalg.solve(stiffness(system, q), gradient(system, rod.end).T)
    return float(np.linalg.norm(ends[1] - ends[0])), float(
        np.linalg.norm(z.T @ residual(system, q))
    )


def main():
    print(
        "estimates over true errors: by adjoints, by the finer pilot; work over that of the pilot"
    )
    line = "{:22} {:6} {:8.1e} m {:6.2f} {:6.2f} {:6.2f}"
    for name, make in STATICS.items():
        true, one, other, mine, its = of_equilibrium(make, 12)
        print(line.format(name, "mesh", true, one / true, other / true, mine / its))
    for name, case in MOTIONS.items():
        *rows, growth, _ = of_motion(*case)
        for what, (true, one, other, mine, its) in zip(("mesh", "steps"), rows, strict=True):
            print(line.format(name, what, true, one / true, other / true, mine / its))
        print(f"{'':22} sensitivities grow {growth:.2g} times")
    print("double pendulum: error of steps true, by the adjoint, by halved steps [m]; growth")
    for t_end in (1.0, 3.0, 6.0, 10.0):
        _, (true, one, other, *_), growth, size = of_motion(double, t_end, 2, round(400 * t_end))
        print(f"{t_end:4g} s {true:9.2g} {one:9.2g} {other:9.2g} {growth:9.2g}"
              + " blown up" * has_blown_up(one, size))  # fmt: skip
    print("shear of a cantilever by the residual of thick beams, over the true one")
    for height in (0.05, 0.1, 0.2):
        shares = [of_shear(height, n) for n in (8, 16)]
        print(f"{height:4g} m", *(f"{one / true:6.2f}" for true, one in shares))


if __name__ == "__main__":
    main()
