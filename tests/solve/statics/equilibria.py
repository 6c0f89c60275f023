"""Scenes at rest, and how well an equilibrium balances."""

import numpy as np

import ancfsparse as ancf
from tests.beams import build_beam
from tests.grids import level_grid
from tests.matrices import stiffness


def unbalanced(equilibrium):
    """Largest share of the loads that is unbalanced, by an independent sum."""
    system, q = equilibrium.system, equilibrium.q
    rest = np.zeros(system.n_all)
    amplitudes = system.loads.amplitudes(np.zeros(1))[0]
    r, phi = system.assembly.residual(q, rest, rest, equilibrium.lam, system.dead_load, amplitudes)
    assert np.abs(phi).max(initial=0.0) <= 1e-13 * np.abs(system.q0).max()
    return np.abs(r[: system.n_free]).max() / np.abs(system.dead_load[: system.n_free]).max()


def eigenvalues(equilibrium):
    """Eigenvalues of the stiffness over the motions that the constraints allow."""
    system = equilibrium.system
    n = system.n_free
    amplitudes = system.loads.amplitudes(np.zeros(1))[0]
    whole = stiffness(system, equilibrium.q, equilibrium.lam, amplitudes).toarray()
    allowed = np.linalg.svd(whole[n:, :n])[2][len(whole) - n :] if len(whole) > n else np.eye(n)
    return np.linalg.eigvalsh(allowed @ whole[:n, :n] @ allowed.T)


def cable(length=1.0, thickness=0.02, n=8, hold="pin", **options):
    """A cable between two holds under gravity, with loads that bend it alike at any length."""
    section = ancf.Circle(thickness * length)
    material = ancf.Material(1e9 * length, 1000.0)
    scene, rod = build_beam("thin", (0, 0), (length, 0), n, section, material, **options)
    for node in (rod.start, rod.end):
        getattr(scene, hold)(node)
    return scene, rod


def square_net(n, side=4.0, youngs_modulus=1e8, diameter=0.02, **options):
    """A flat net whose rim is pinned."""
    nodes, pairs, number = level_grid(n, side)
    scene = ancf.Scene((0.0, 0.0, -9.81))
    section, material = ancf.Circle(diameter), ancf.Material(youngs_modulus, 1000.0)
    net = scene.add_mesh(nodes, pairs, "thin", section, material, **options)
    for k in np.unique([number[0], number[-1], number[:, 0], number[:, -1]]):
        scene.pin(net.node(int(k)))
    return scene, net.node(int(number[n // 2, n // 2]))
