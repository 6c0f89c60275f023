"""Assembly: put a scene where its joints and drives hold, with as little motion as that takes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_finite
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import AssemblyError
from ancfsparse.nonlinear import Newton
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.results.solutions.assembly import Assembly
from ancfsparse.scene import Scene, check_scene
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.linearization.linearized_system import RELATIVE_FLEXIBILITY
from ancfsparse.solve.preparation.memory_estimate import (
    check_factor_fits,
    estimate_memory,
    within_memory,
)
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.system.assembly.assembly_protocol import Assembly as Equations

Vector = NDArray[np.float64]

# Arrays of values on the pattern.
MATRICES = 8
# Mass beside stiffness: so little that bodies deform only where rigid motions do not suffice, and
# well above the rounding of the stiffness.
LIGHT = 1e-8
# Largest change of a slope in a correction [rad], the most corrections, and those after which they
# must have become smaller.
LARGEST_TURN, MOST, PATIENCE = 0.1, 300, 60
# Displacement of a drive over which forces are differentiated, as a share of its way.
SMALL = 1e-6
# Rounding of an equation in units of eps.
ROUNDING = 256.0


def assemble(scene: Scene, *, t: float = 0.0) -> Assembly:
    """Move a scene to where its joints hold and its drives are, without regard to loads.

    The bodies move as little as possible, measured by their masses, and deform only where they
    must.  ``simulate(scene, ..., start=assemble(scene))`` starts there, and ``solve_static(scene,
    start=assemble(scene))`` finds the equilibrium next to it.

    Parameters
    ----------
    scene : Scene
        Bodies and joints; the joints may be violated in the reference shape, as by drives that
        begin somewhere else or by ``connect(..., apart=True)``.
    t : float, optional
        Time at which drives are evaluated [s].

    Returns
    -------
    Assembly
        The state, how much was violated, and how far which node has moved.

    Raises
    ------
    InputError
        If an argument is invalid, or the factor cannot fit in memory.
    AssemblyError
        If the joints cannot be satisfied together from here; the worst is named.

    Notes
    -----
    Gauss-Newton corrections, each the least motion that satisfies the linearised equations: by
    strain energy, and where that does not decide by mass.  Bodies that deform are not in
    equilibrium yet.
    """
    check_scene(scene)
    t = check_finite("t", t, "s")
    with within_memory(estimate_memory(scene, 0, 0, False, Newton(), matrices=MATRICES)) as _:
        system = System(scene)
        return _Work(system, t).run()


class _Work:
    """The equations of an assembly.

    Parameters
    ----------
    system : System
        What is assembled.
    t : float
        The time [s].
    """

    def __init__(self, system: System, t: float) -> None:
        self.system, self.t = system, t
        n, m = system.n_free, system.n_multipliers
        self.seed = SparseSeed(system.pattern.indptr, system.pattern.indices, n)
        check_factor_fits(estimate_memory(system.scene, 0, 0, False, Newton()), self.seed)
        self.mass = system.mass_diagonal
        self.positions = system.positions
        slopes = np.ones(system.n_all, dtype=bool)
        slopes[self.positions] = False
        self.slopes = np.flatnonzero(slopes[:n])
        # Springs, loads and functions of the motion do nothing here.
        self.idle = np.zeros(system.loads.n_amplitudes)
        self.none, self.lam = np.zeros(system.n_all), np.zeros(m)
        self.now = system.prescribed.at(t) if system.prescribed else None
        pairs = zip(system.contributions, system.parts, strict=True)
        self.assembly: Equations = compiled_module("assembly").Assembly(
            n,
            system.n_all,
            system.loads.n_amplitudes,
            system.pattern.indptr,
            [part for each, part in pairs if not each.pushes],
        )
        diagonal = self.assembly.material(0.0, 1.0, system.q_ref)[system.pattern.indptr[:n]]
        size = float(np.max(np.abs(diagonal) / self.mass))
        self.shift = LIGHT * size or 1.0

    def violations(self, q: Vector) -> Vector:
        """Return by how much the equations are violated, (m,) [m]."""
        args = self.none, self.none, self.lam, self.none, self.idle
        phi = np.array(self.assembly.residual(q, *args)[1])
        if self.now is not None and len(self.now.s):
            phi[len(phi) - len(self.now.s) :] -= self.now.s
        return phi[: len(self.lam)]

    def allowed(self, q: Vector) -> Vector:
        """Return the rounding of the equations (m,) [m]."""
        span = np.max(np.abs(q[self.positions]), initial=0.0)
        return np.asarray(ROUNDING * EPSILON * (span + self.system.constraints.sizes(q)))

    def run(self) -> Assembly:
        """Correct until the equations hold and drives are where they should be."""
        system, n = self.system, self.system.n_free
        q = system.q_ref.copy()
        far, phi = self.to_drives(q), self.violations(q)
        before = float(max(np.max(np.abs(far)), np.max(np.abs(phi), initial=0.0)))
        sizes: list[float] = []
        while len(sizes) < MOST:
            if not far.any() and np.all(np.abs(phi) <= self.allowed(q)):
                worst = self.worst(self.violations(system.q_ref))
                return Assembly(system, q, self.t, before, worst, self.lam)
            dq = far.copy()
            dq[:n] = self._correction(q, far, phi)
            turn = float(np.max(np.abs(dq[self.slopes]), initial=0.0))
            share = LARGEST_TURN / max(LARGEST_TURN, turn)
            q = q + share * dq
            far = (1.0 - share) * far if share < 1.0 else self.none
            phi = self.violations(q)
            sizes.append(float(np.sqrt(self.mass @ dq[:n] ** 2 / self.mass.sum())))
            few = len(sizes) <= PATIENCE or sizes[-1] <= 0.9 * min(sizes[: -PATIENCE // 2])
            if not (np.isfinite(sizes[-1]) and few):
                break
        raise AssemblyError(self.worst(phi) or "drive", float(np.max(np.abs(phi))), before)

    def to_drives(self, q: Vector) -> Vector:
        """Return how far driven coordinates are from where they should be, (n_all,) [m, 1]."""
        far = np.zeros_like(q)
        if self.now is not None and len(self.now.q):
            first = len(q) - len(self.now.q)
            far[first:] = self.now.q - q[first:]
        return far

    def worst(self, phi: Vector) -> str:
        """Return the name of the equation that is violated most, if any."""
        if not len(phi) or not phi.any():
            return ""
        return self.system.constraints.labels[int(np.argmax(np.abs(phi)))]

    def _correction(self, q: Vector, far: Vector, phi: Vector) -> Vector:
        """Return the least motion that satisfies the linearised equations, (n_free,) [m, 1]."""
        system, n, m = self.system, self.system.n_free, self.system.n_multipliers
        values = np.array(self.assembly.material(1.0, 1.0 / self.shift, q))
        phi_q = system.constraints.jacobian(q)
        if m:
            diagonal = values[system.pattern.indptr[:n]]
            flexible = phi_q[:, :n].power(2) @ (1.0 / np.abs(diagonal))
            flexible[flexible == 0.0] = np.max(flexible, initial=1.0 / np.max(diagonal))
            values[system.pattern.indptr[n : n + m]] -= RELATIVE_FLEXIBILITY * flexible
        self.seed.factor(values)
        force, ahead = np.zeros(n), np.zeros(m)
        if far.any():  # what moving drives pull along
            small = SMALL / float(np.max(np.abs(far)))
            change = self.assembly.force(q + small * far) - self.assembly.force(q - small * far)
            force, ahead = change[:n] / (2.0 * small), phi_q @ far
        target = -phi - ahead
        r = np.concatenate([-force / self.shift, target])
        x = np.array(self.seed.solve(r))
        if m:  # what the flexibility has left
            r[:n], r[n:] = 0.0, target - phi_q[:, :n] @ x[:n]
            x += self.seed.solve(r)
        return x[:n]
