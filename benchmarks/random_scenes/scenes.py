"""Scenes drawn at random, and their motions by independent integrators."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import ancfsparse as ancf
from ancfsparse.system import System

SAVED = 50  # times at which motions are compared, the start not counted

KINDS = (
    "soft",
    "stiff",
    "damped",
    "constrained",
    "jump",
    "damped jump",
    "spatial",
    "constrained jump",
)


@dataclass
class Case:
    """A scene, the time it moves for, and when its loads jump."""

    seed: int
    kind: str
    scene: ancf.Scene
    t_end: float
    jumps: tuple[float, ...]


def make(seed: int) -> Case:
    """Return a scene: its kind alternates with the seed, all else is drawn at random."""
    kind = KINDS[seed % len(KINDS)]
    r = np.random.default_rng([10, seed])
    dim = 3 if kind == "spatial" or r.random() < 0.3 else 2
    length = 10 ** r.uniform(-0.5, 0.5)
    width = length * 10 ** r.uniform(-2.3, -1.7)
    youngs = 10 ** (r.uniform(9.5, 11.3) if kind == "stiff" else r.uniform(6.5, 8.5))
    density = 10 ** r.uniform(3.0, 3.9)
    damping: dict[str, Any] = {}
    if kind.startswith("damped"):
        damping = {
            "axial_damping": 10 ** r.uniform(-5, -3),
            "bending_damping": 10 ** r.uniform(-4, -2),
        }
    material = ancf.Material(youngs, density, **damping)
    gravity = np.zeros(dim)
    gravity[1] = -9.81
    scene = ancf.Scene(tuple(gravity))
    # Times of a pendulum of this length; short where waves are fast.
    n = int(r.integers(3, 9))
    t_end = 0.7 * np.sqrt(length / 9.81) * r.uniform(0.6, 1.5)
    along = np.zeros(dim)
    angle = r.uniform(-1.2, 0.3)
    along[:2] = np.cos(angle), np.sin(angle)
    end = length * along
    support = (
        r.choice(["pin", "clamp", "two pins"]) if not kind.startswith("constrained") else "pin"
    )
    velocity: Any = None
    if support != "clamp" and r.random() < 0.5:
        across = np.zeros(dim)
        across[:2] = -along[1], along[0]
        if dim == 3:
            across = across + r.normal() * np.array([0.0, 0.0, 1.0])
        waves, speed = int(r.integers(1, 3)), r.uniform(0.2, 1.0) * np.sqrt(length)

        def velocity(x: Any) -> Any:
            return np.outer(np.sin(waves * np.pi * (x @ along) / length), speed * across)

    beam = scene.add_beam(
        "thin", np.zeros(dim), end, n, ancf.Rectangle(width, width), material, velocity=velocity
    )
    if support == "clamp":
        scene.clamp(beam.start)
    elif support == "two pins":
        scene.pin(beam.start)
        scene.pin(beam.end)
    elif kind.startswith("constrained") and r.random() < 0.5:
        scene.rod(beam.start, tuple(np.array(beam.start.position) + length * np.eye(dim)[1]))
        if velocity is not None or r.random() < 0.5:
            scene.rod(beam.end, tuple(np.array(beam.end.position) + 0.7 * length * np.eye(dim)[1]))
    else:
        scene.pin(beam.start, as_constraint=kind.startswith("constrained"))
    weight = density * width**2 * length * 9.81
    force = weight * 10 ** r.uniform(-1.0, 0.0) * r.normal(size=dim)
    node = beam.node(int(r.integers(1, n))) if support == "two pins" else beam.end
    jumps: tuple[float, ...] = ()
    if kind.endswith("jump"):
        first, second = sorted(r.choice(np.arange(3, 47), 2, replace=False) * t_end / SAVED)
        jumps = (first, second)
        near = 1e-9 * t_end
        if r.random() < 0.5:
            wave = 0.0
        else:
            wave = 3.0 / t_end

        def load(t: float) -> Any:
            if wave == 0.0:
                return force * (first - near <= t < second - near)
            return force * ((t >= first - near) + np.sin(wave * t) * (t < second - near))

        scene.point_force(node, load)
    elif r.random() < 0.7:
        rate = r.uniform(1.0, 12.0) / t_end
        scene.point_force(node, lambda t: force * np.sin(rate * t) ** 2)
    return Case(seed, kind, scene, float(t_end), jumps)


def positions(system: System, q: Any) -> Any:
    """Return the positions of all nodes at all times, (k, n, dim)."""
    dim = system.dim
    return np.concatenate([q[:, p[:, :dim]] for p in system.places], axis=1)


def distance(result: Any, exact: Any) -> float:
    """Return the largest distance of a node from its place in another motion [m]."""
    return float(np.linalg.norm(result - exact, axis=2).max())


def reference(case: Case) -> tuple[Any, float]:
    """Return positions at the saved times, and how far they may be off [m].

    Runge-Kutta-Nystrom of order 8 where the scene allows it; else SciPy's DOP853, restarted at
    each jump, on the equations with multipliers eliminated.
    """
    system = System(case.scene)
    if not (system.damped or system.n_multipliers or case.jumps):
        method = ancf.RungeKuttaNystrom(8)
        limit = ancf.stable_step(case.scene, method)
        runs = []
        for ratio in (0.45, 0.3):
            steps = SAVED * int(np.ceil(case.t_end / SAVED / (ratio * limit)))
            run = ancf.simulate(
                case.scene, case.t_end, case.t_end / steps, integrator=method,
                save_every=steps // SAVED, max_energy_gain=np.inf,
            )  # fmt: skip
            runs.append(positions(run.system, run.q))
        return runs[1], distance(*runs)
    runs = [positions(system, integrate_by_scipy(case, system, tight)) for tight in (1e-8, 1e-9)]
    return runs[1], distance(*runs)


def integrate_by_scipy(case: Case, system: System, tight: float) -> Any:
    """Return the coordinates at the saved times by DOP853 to a relative tolerance."""
    n, m = system.n_free, system.n_multipliers
    none = np.zeros(system.n_all)
    mass = np.zeros((n, n))
    for k in range(n):
        unit = none.copy()
        unit[k] = 1.0
        mass[:, k] = system.assembly.inertia(unit)[:n]
    inverse = np.linalg.inv(mass)
    times = np.linspace(0.0, case.t_end, SAVED + 1)

    def rate(t: float, y: Any, last: float) -> Any:
        q, v = system.q0.copy(), np.zeros(system.n_all)
        q[:n], v[:n] = y[:n], y[n:]
        load = system.loads.amplitudes(np.array([min(t, last)]))[0]
        r, _ = system.assembly.residual(q, v, none, np.zeros(m), system.dead_load, load)
        a = inverse @ -r[:n]
        if m:
            across = system.constraints.jacobian(q).toarray()[:, :n]
            moved = inverse @ across.T
            want = -system.constraints.curvature(q, v) - across @ a
            a += moved @ np.linalg.solve(across @ moved, want)
        return np.concatenate([y[n:], a])

    out = [system.q0]
    y = np.concatenate([system.q0[:n], system.v0[:n]])
    near = 1e-7 * case.t_end
    ends = [*case.jumps, case.t_end]
    begin = 0.0
    for end in ends:
        inside = np.minimum(times[(times > begin + near) & (times < end + near)], end)
        last = end - near if end < case.t_end else end
        with np.errstate(over="ignore", invalid="ignore"):  # of trial steps
            solved = solve_ivp(
                rate,
                (begin, end),
                y,
                "DOP853",
                np.union1d(inside, end),
                args=(last,),
                rtol=tight,
                atol=1e-2 * tight,
            )
        assert solved.success
        for column in solved.y[:, : len(inside)].T:
            q = system.q0.copy()
            q[:n] = column[:n]
            out.append(q)
        y, begin = solved.y[:, -1], end
    return np.array(out)
