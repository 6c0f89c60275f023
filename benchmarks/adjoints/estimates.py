"""Estimate errors by residuals weighted with adjoint solutions, a prototype.

``python -m benchmarks.adjoints.estimates`` prints the estimates of dual-weighted residuals (Becker
and Rannacher 2001; of models Braack and Ern 2003), the errors, and the estimates by two meshes and
halved steps, with their counted work.  docs/model.md has the conclusions.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

import ancfsparse as ancf
from ancfsparse.plans.models.prolongation import prolongate
from ancfsparse.plans.trial_runs.cost_model import COORDINATE_COSTS, STEP_OVERHEAD, cost_of_run
from ancfsparse.system import System

# Generalized alpha of Arnold and Bruels (2007), by its spectral radius.
RHO = 0.9
ALPHA_M = (2.0 * RHO - 1.0) / (RHO + 1.0)
ALPHA_F = RHO / (RHO + 1.0)
GAMMA = 0.5 + ALPHA_F - ALPHA_M
BETA = 0.25 * (0.5 + GAMMA) ** 2
RATIO = (1.0 - ALPHA_F) / (1.0 - ALPHA_M)
SHEAR = {"curvature": "section", "section_strain": "nodal"}

Make = Callable[[int], tuple[ancf.Scene, Any]]
Array = np.ndarray[Any, Any]


def matrix(system: System, values: Any) -> Array:
    """Return the free part of a symmetric matrix from its lower triangle, dense."""
    pattern, n = system.pattern, system.n_free
    count = len(pattern.indptr) - 1
    entries = np.asarray(values)[: len(pattern.indices)]
    lower = sp.tril(sp.csc_array((entries, pattern.indices, pattern.indptr), shape=(count, count)))
    full: Array = (lower + lower.T - sp.diags_array(lower.diagonal())).toarray()
    return full[:n, :n]


def stiffness(system: System, q: Array, t: float = 0.0) -> Array:
    """Return the stiffness over the unconstrained coordinates."""
    amplitudes = system.loads.amplitudes(np.array([t]))[0]
    lam = np.zeros(system.n_multipliers)
    return matrix(system, system.assembly.matrix(0.0, 1.0, q, lam, amplitudes))


def residual(
    system: System, q: Array, v: Array | None = None, a: Array | None = None, t: float = 0.0
) -> Array:
    """Return the residual over the unconstrained coordinates."""
    amplitudes = system.loads.amplitudes(np.array([t]))[0]
    rest, lam = np.zeros_like(q), np.zeros(system.n_multipliers)
    v, a = (rest if rates is None else np.ascontiguousarray(rates) for rates in (v, a))
    q = np.ascontiguousarray(q)
    out = system.assembly.residual(q, v, a, lam, system.dead_load, amplitudes)[0]
    return np.array(out)[: system.n_free]


def gradient(system: System, node: Any) -> Array:
    """Return the derivative of a position by the free coordinates, (dim, n_free)."""
    indices, weights = system.point(node)
    out = np.zeros((len(indices), len(system.q_ref)))
    for row, columns in zip(out, indices, strict=True):
        np.add.at(row, columns, weights)
    return out[:, : system.n_free]


def interpolate_on_finer(coarse: System, table: Any, system: System) -> Array:
    """Return a table of coordinates (k, n_all), or of their rates, on another mesh."""
    out = np.empty((len(table), len(system.q_ref)))
    for row, q in zip(out, np.asarray(table), strict=True):
        state: Any = prolongate(_Run(coarse, q[None]), system.scene)  # type: ignore[arg-type]
        for fine, coarse_indices in zip(system.places, state.layout.places, strict=True):
            row[fine] = state.q[coarse_indices]
    return out


class _Run:
    """A run of one state, as far as `prolonged` reads it."""

    def __init__(self, system: System, q: Array) -> None:
        self.system, self.q, self.t = system, q, np.zeros(1)


def halve_steps(run: Any) -> tuple[Array, list[Array]]:
    """Return times and states of a run with the middle of every step, by quintics."""
    q, v, a = (np.asarray(x) for x in (run.q, run.v, run.a))
    h = run.t[1] - run.t[0]
    middle = (
        0.5 * (q[:-1] + q[1:]) + 5 / 32 * h * (v[:-1] - v[1:]) + h * h / 64 * (a[:-1] + a[1:]),
        15 / 8 * (q[1:] - q[:-1]) / h - 7 / 16 * (v[:-1] + v[1:]) + h / 32 * (a[:-1] - a[1:]),
        1.5 * (v[1:] - v[:-1]) / h - 0.25 * (a[:-1] + a[1:]),
    )
    states: list[Array] = []
    for table, between in zip((q, v, a), middle, strict=True):
        states.append(np.empty((2 * len(table) - 1, table.shape[1])))
        states[-1][::2], states[-1][1::2] = table, between
    return np.linspace(run.t[0], run.t[-1], 2 * len(run.t) - 1), states


class LinearizedSteps:
    """Steps of generalized alpha about given states, with the residuals of these."""

    def __init__(self, system: System, t: Array, states: Any) -> None:
        n = self.n = system.n_free
        self.system, self.t, self.h = system, t, t[1] - t[0]
        q, v, a = (np.array(x) for x in states)
        q[:, n:], v[:, n:], a[:, n:] = system.q_ref[n:], 0.0, 0.0
        self.q = q
        h, b = self.h, np.zeros((len(t), n))
        b[0] = a[0, :n]
        self.r, self.dq, self.dv = np.zeros((3, len(t), n))
        for i in range(1, len(t)):
            b[i] = (ALPHA_F * a[i - 1, :n] - ALPHA_M * b[i - 1]) / (1 - ALPHA_M) + RATIO * a[i, :n]
            went = h * v[i - 1, :n] + h * h * ((0.5 - BETA) * b[i - 1] + BETA * b[i])
            self.dq[i] = q[i, :n] - q[i - 1, :n] - went
            sped = h * ((1.0 - GAMMA) * b[i - 1] + GAMMA * b[i])
            self.dv[i] = v[i, :n] - v[i - 1, :n] - sped
            self.r[i] = residual(system, q[i], v[i], a[i], t[i])

    @cached_property
    def matrices(self) -> list[Any]:
        """Stiffness and factor of the matrix of every step."""
        mass = matrix(self.system, self.system.assembly.mass)
        out: list[Any] = [None]
        for q, t in zip(self.q[1:], self.t[1:], strict=True):
            k = stiffness(self.system, q, t)
            out.append((k, la.lu_factor(mass + self.h**2 * BETA * RATIO * k)))
        return out

    def tangent(self) -> Array:
        """Return the difference of the solution of the steps from the states, (k, n)."""
        h, (dq, dv, da, db) = self.h, np.zeros((4, self.n))
        out = [dq]
        for i in range(1, len(self.t)):
            k, factor = self.matrices[i]
            new = (ALPHA_F * da - ALPHA_M * db) / (1.0 - ALPHA_M)
            dq = dq + h * dv + h * h * ((0.5 - BETA) * db + BETA * new) - self.dq[i]
            dv = dv + h * ((1.0 - GAMMA) * db + GAMMA * new) - self.dv[i]
            da = la.lu_solve(factor, -k @ dq - self.r[i])
            db = new + RATIO * da
            dq = dq + h * h * BETA * RATIO * da
            dv = dv + h * GAMMA * RATIO * da
            out.append(dq)
        return np.array(out)

    def adjoint(self, goal: Array) -> tuple[float, float]:
        """Return the difference of a goal at the end, and its largest sensitivity.

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
            k, factor = self.matrices[i]
            force = za + h * h * BETA * RATIO * zq + h * GAMMA * RATIO * zv + RATIO * zb
            w = la.lu_solve(factor, force, trans=1)
            zq = zq - k.T @ w
            out -= w @ self.r[i] + zq @ self.dq[i] + zv @ self.dv[i]
            new = zb + h * h * BETA * zq + h * GAMMA * zv
            zb = h * h * (0.5 - BETA) * zq + h * (1.0 - GAMMA) * zv
            zb = zb - ALPHA_M / (1.0 - ALPHA_M) * new
            za = ALPHA_F / (1.0 - ALPHA_M) * new
            zv = zv + h * zq
            largest = max(largest, float(np.abs(zq).max()))
        return out, largest / float(np.abs(goal).max())

    @property
    def work(self) -> float:
        """Counted work: a residual, a factor and a solution for every step."""
        return (len(self.t) - 1) * COORDINATE_COSTS.total(1, 1, 1) * (self.n + STEP_OVERHEAD)


def beam(
    element: str,
    n: int,
    section: Any,
    material: ancf.Material,
    end: tuple[float, float] = (1.0, 0.0),
    gravity: float = -9.81,
    **options: Any,
) -> tuple[ancf.Scene, Any]:
    """Return a scene with a beam from the origin."""
    scene = ancf.Scene((0.0, gravity))
    return scene, scene.add_beam(element, (0.0, 0.0), end, n, section, material, **options)


def pendulum(n: int) -> tuple[ancf.Scene, Any]:
    """Return a swinging cable and its end."""
    scene, rod = beam("thin", n, ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4e3), (2.0, 0.0))
    scene.pin(rod.start)
    return scene, rod.end


def cantilever(n: int) -> tuple[ancf.Scene, Any]:
    """Return a cantilever under a force that grows smoothly, and its end."""
    bar = ancf.Rectangle(0.01, 0.01), ancf.Material(2e9, 1e3)
    scene, rod = beam("thin", n, *bar, gravity=0.0)
    scene.clamp(rod.start)
    scene.point_force(rod.end, ancf.Ramp((0.0, -2.0), 0.3, smooth=True))
    return scene, rod.end


def taut(n: int) -> tuple[ancf.Scene, Any]:
    """Return a taut line that is pushed aside, and its middle."""
    scene, rod = beam("thin", n, ancf.Circle(0.002), ancf.Material(1e9, 1e3), tension=20.0)
    scene.pin(rod.start)
    scene.pin(rod.end)
    middle = rod.at(0.5 * rod.length)
    scene.point_force(middle, ancf.Ramp((0.0, -1.0), 0.05, smooth=True))
    return scene, middle


def steel(n: int) -> tuple[ancf.Scene, Any]:
    """Return a swinging rod of steel and its end."""
    bar = ancf.Rectangle(0.01, 0.01), ancf.Material(2.1e11, 7850.0)
    scene, rod = beam("thin", n, *bar, (2.0, 0.0))
    scene.pin(rod.start)
    return scene, rod.end


def double(n: int) -> tuple[ancf.Scene, Any]:
    """Double pendulum of stiff rods that starts nearly upright."""
    bar = ancf.Rectangle(0.03, 0.03), ancf.Material(1e10, 1e3)
    elbow = (0.3, 0.954)
    scene, arm = beam("thin", n, *bar, elbow)
    other = scene.add_beam("thin", elbow, (0.4, 1.949), n, *bar)
    scene.pin(arm.start)
    scene.connect(arm.end, other.start)
    return scene, other.end


def droop(n: int) -> tuple[ancf.Scene, Any]:
    """Return a cantilever under its weight, and its end."""
    scene, rod = beam("thin", n, ancf.Circle(0.01), ancf.Material(1e7, 1e3))
    scene.clamp(rod.start)
    return scene, rod.end


def sagging(n: int) -> tuple[ancf.Scene, Any]:
    """Return a line between two pins, and a point of it."""
    scene, rod = beam("thin", n, ancf.Circle(0.01), ancf.Material(1e7, 1e3), length=1.1)
    scene.pin(rod.start)
    scene.pin(rod.end)
    return scene, rod.at(0.4)


def clamped(n: int) -> tuple[ancf.Scene, Any]:
    """Return a beam between two clamps under a uniform force, and its middle."""
    scene, rod = beam("thin", n, ancf.Rectangle(0.01, 0.01), ancf.Material(2e9, 1e3))
    scene.clamp(rod.start)
    scene.clamp(rod.end)
    scene.distributed_force(rod, (0.0, -100.0))
    return scene, rod.at(0.5)


MOTIONS: dict[str, tuple[Make, float, int, int]] = {
    "pendulum, 0.5 s": (pendulum, 0.5, 8, 100),
    "pendulum, 2 s": (pendulum, 2.0, 8, 400),
    "cantilever, 0.5 s": (cantilever, 0.5, 8, 200),
    "taut line, 0.1 s": (taut, 0.1, 8, 100),
    "steel pendulum, 1 s": (steel, 1.0, 8, 200),
}
STATICS: dict[str, Make] = {"drooping rod": droop, "sagging line": sagging, "clamped beam": clamped}


def integrate(make: Make, n: int, t_end: float, steps: int) -> tuple[ancf.Trajectory, Any]:
    """Return a run with fixed steps, and the point of interest."""
    scene, node = make(n)
    integrator = ancf.GeneralizedAlpha(RHO)
    return ancf.simulate(scene, t_end, t_end / steps, integrator=integrator), node


def work(run: Any) -> float:
    """Return the counted work of a run."""
    return cost_of_run(run.stats, len(run.t) - 1, run.q.shape[1]).work


def compare_motion(make: Make, t_end: float, n: int, steps: int) -> tuple[Any, Any, float, float]:
    """Return errors at the end, true, by adjoints, and by the finer run, with the work of both.

    A tuple for the mesh and one for the steps; then the growth of sensitivities, and the size of
    the motion [m].
    """
    run, node = integrate(make, n, t_end, steps)
    path = run.position(node)

    def difference(n: int, steps: int) -> tuple[Array, Any]:
        other, point = integrate(make, n, t_end, steps)
        return other.position(point)[-1] - path[-1], other

    scene, point = make(2 * n)
    system = System(scene)
    states = [interpolate_on_finer(run.system, each, system) for each in (run.q, run.v, run.a)]
    finer = LinearizedSteps(system, run.t, states)
    by_finer = np.array([finer.adjoint(goal)[0] for goal in gradient(system, point)])
    shorter = LinearizedSteps(run.system, *halve_steps(run))
    swept = [shorter.adjoint(goal) for goal in gradient(run.system, node)]
    by_shorter = np.array([each[0] for each in swept])
    second, its_run = difference(3 * n // 2, steps)
    half, half_run = difference(n, 2 * steps)
    mesh = difference(4 * n, steps)[0], by_finer / (1.0 - 2.0**-4), second / (1.0 - 1.5**-4)
    time = difference(n, 8 * steps)[0], by_shorter / (1.0 - 2.0**-2), half / (1.0 - 2.0**-2)
    return (
        (*map(np.linalg.norm, mesh), finer.work, work(its_run)),
        (*map(np.linalg.norm, time), shorter.work, work(half_run)),
        max(each[1] for each in swept),
        float(np.linalg.norm(path - path[0], axis=1).max()),
    )


def has_blown_up(estimate: float, size: float) -> bool:
    """Return True if an estimate is larger than the motion, so no perturbation."""
    return not estimate <= size


def compare_equilibrium(make: Make, n: int) -> tuple[Any, ...]:
    """Return errors, true, by the adjoint, and by the finer mesh, with the work of both."""
    results: dict[int, Any] = {}
    for count in (n, 3 * n // 2, 16 * n):
        scene, node = make(count)
        first = next(iter(results.values()), None)
        start: Any = None
        if first is not None:
            run = _Run(first[0].system, first[0].q[None])
            start = prolongate(run, scene)  # type: ignore[arg-type]
        equilibrium = ancf.solve_static(scene, start=start)
        results[count] = equilibrium, equilibrium.position(node)
    coarse, position = results[n]
    scene, node = make(2 * n)
    system = System(scene)
    (q,) = interpolate_on_finer(coarse.system, coarse.q[None], system)
    z = np.linalg.solve(stiffness(system, q), gradient(system, node).T)
    by_adjoint = -(z.T @ residual(system, q)) / (1.0 - 2.0**-4)
    second, other = results[3 * n // 2][0], results[3 * n // 2][1] - position
    errors = results[16 * n][1] - position, by_adjoint, other / (1.0 - 1.5**-4)
    adjoint_work = COORDINATE_COSTS.total(1, 1, 1) * (system.n_free + STEP_OVERHEAD)
    count = second.system.n_free
    return (*map(np.linalg.norm, errors), adjoint_work, cost_of_run(second.stats, 1, count).work)


def compare_shear(height: float, n: int) -> tuple[float, float]:
    """Return the deflection of a cantilever by shear, true and by the residual of thick beams."""
    force = -0.15 * 1e8 * height**4 / 12.0

    def build(element: str, n: int, **options: Any) -> tuple[ancf.Scene, Any]:
        section = ancf.Rectangle(height, height)
        scene, rod = beam(element, n, section, ancf.Material(1e8, 1e3, 0.3), gravity=0.0, **options)
        scene.clamp(rod.start)
        scene.point_force(rod.end, (0.0, force))
        return scene, rod

    ends = []
    for scene, rod in (build("thin", 64), build("thick", 512, **SHEAR)):
        ends.append(ancf.solve_static(scene).position(rod.end))
    cable = ancf.solve_static(build("thin", n)[0])
    scene, rod = build("thick", n, **SHEAR)
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


def main() -> None:
    """Print the table of docs/model.md."""
    print("estimates over true errors: by adjoints, by the finer run; work over that of the run")
    line = "{:22} {:6} {:8.1e} m {:6.2f} {:6.2f} {:6.2f}"
    for name, make in STATICS.items():
        true, one, other, adjoint, finer = compare_equilibrium(make, 12)
        print(line.format(name, "mesh", true, one / true, other / true, adjoint / finer))
    for name, case in MOTIONS.items():
        *rows, growth, _ = compare_motion(*case)
        for part, (true, one, other, adjoint, finer) in zip(("mesh", "steps"), rows, strict=True):
            print(line.format(name, part, true, one / true, other / true, adjoint / finer))
        print(f"{'':22} sensitivities grow {growth:.2g} times")
    print("double pendulum: error of steps true, by the adjoint, by halved steps [m]; growth")
    for t_end in (1.0, 3.0, 6.0, 10.0):
        steps = round(400 * t_end)
        _, (true, one, other, *_), growth, size = compare_motion(double, t_end, 2, steps)
        print(f"{t_end:4g} s {true:9.2g} {one:9.2g} {other:9.2g} {growth:9.2g}"
              + " blown up" * has_blown_up(one, size))  # fmt: skip
    print("shear of a cantilever by the residual of thick beams, over the true one")
    for height in (0.05, 0.1, 0.2):
        ratios = [compare_shear(height, n) for n in (8, 16)]
        print(f"{height:4g} m", *(f"{one / true:6.2f}" for true, one in ratios))


if __name__ == "__main__":
    main()
