"""A system that can be checked by hand: one planar beam, its coordinates in reversed order."""

import h5py
import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

from ancfsparse.problems import pendulum
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.system import recovery

mpl.use("Agg")


class ReversedBeam:
    """Keep the coordinates r, r' of all nodes of one planar beam, last one first.

    The reversal makes sure that results go through the places they are given.  Energies and
    power are those of a unit point mass at the tip, under gravity 9.81 in -y and a force of
    2 N in +x, and with a drag [kg/s] that is zero unless set.
    """

    drag = 0.0

    is_driven = False

    def __init__(self, rod):
        self.rod = rod
        self.n = 4 * rod.n_nodes

    def _places(self, first):
        return self.n - 1 - (np.asarray(first)[None, :] + np.arange(2)[:, None])

    def _element(self, node):
        inner = min(node.index, self.rod.n_elements - 1)
        return inner, node.index + node.xi - inner, self.rod.length / self.rod.n_elements

    def elements(self, rod):
        return self.n - 1 - (4 * np.arange(rod.n_elements)[:, None] + np.arange(8))

    def point(self, node):
        e, x, length = self._element(node)
        weights = [1 - 3*x**2 + 2*x**3, length*(x - 2*x**2 + x**3), 3*x**2 - 2*x**3,
                   length*(x**3 - x**2)]  # fmt: skip
        return self._places(4 * e + np.array([0, 2, 4, 6])), np.array(weights)

    def slope(self, node):
        e, x, length = self._element(node)
        weights = [(6*x**2 - 6*x)/length, 1 - 4*x + 3*x**2, (6*x - 6*x**2)/length,
                   3*x**2 - 2*x]  # fmt: skip
        return self._places(4 * e + np.array([0, 2, 4, 6])), np.array(weights)

    def _tip(self, q):
        places, weights = self.point(self.rod.end)
        return q[:, places] @ weights

    has_parametric_work = False
    contributions = ()

    def energies(self, q, v, t=None):
        kinetic = 0.5 * (self._tip(v) ** 2).sum(axis=1)
        return kinetic, np.full(len(q), 0.25), 9.81 * self._tip(q)[:, 1], np.zeros(len(q))

    def power(self, q, v, t):
        return 2.0 * self._tip(v)[:, 0]

    def dissipation(self, q, v, lam):
        return self.drag * (self._tip(v) ** 2).sum(axis=1)

    def reaction(self, node, states):
        return states.lam + self._tip(states.a) + states.t[:, None]

    def state(self, angle, curvature=0.0):
        """Give q for the beam turned by an angle and bent into an arc, shape (n,)."""
        s = self.rod.positions[:, 0]
        theta = angle + curvature * s
        fine = np.linspace(0.0, self.rod.length, 20001)
        path = angle + curvature * fine
        step = fine[1]
        x = np.concatenate([[0.0], np.cumsum(0.5 * step * (np.cos(path)[1:] + np.cos(path)[:-1]))])
        y = np.concatenate([[0.0], np.cumsum(0.5 * step * (np.sin(path)[1:] + np.sin(path)[:-1]))])
        places = np.interp(s, fine, x), np.interp(s, fine, y)
        return np.column_stack([*places, np.cos(theta), np.sin(theta)]).ravel()[::-1]


@pytest.fixture
def close_figures():
    """Leave no figure of matplotlib behind."""
    yield
    plt.close("all")


def damage_outline(path, name, change):
    """Put something else in the place of a table of the outline in a file, or nothing."""
    with h5py.File(path, "a", libver=("v108", "v108")) as file:
        table = change(np.asarray(file["outline"][name]))
        del file["outline"][name]
        if table is not None:
            file["outline"][name] = table


@pytest.fixture
def system(monkeypatch):
    monkeypatch.setattr(recovery, "reaction", ReversedBeam.reaction)
    return ReversedBeam(pendulum(n_elements=4).rod)


@pytest.fixture
def trajectory(system):
    """Let the beam fly with velocity (3 + 2 t, -9.81 t): a unit mass under the loads above."""
    t = np.linspace(0.0, 0.4, 9)
    q = np.tile(system.state(0.0), (9, 1))
    v, a = np.zeros_like(q), np.zeros_like(q)
    for node in range(system.rod.n_nodes):
        x, y = system.n - 1 - 4 * node, system.n - 2 - 4 * node
        q[:, x] += 3.0 * t + t**2
        q[:, y] += -0.5 * 9.81 * t**2
        v[:, x], v[:, y] = 3.0 + 2.0 * t, -9.81 * t
        a[:, x], a[:, y] = 2.0, -9.81
    stats = RunStats(march_seconds=0.002, steps=8, iterations=20, factorizations=1, solver="newton")
    return Trajectory(system, t, q, v, a, np.tile([1.0, 5.0], (9, 1)), stats, {"dt": 0.05})
