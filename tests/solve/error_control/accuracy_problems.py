"""Scenes that runs to an accuracy are tested with, and their motions in fixed steps."""

import math

import numpy as np

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from tests.beams import build_beam

SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)
T_END, TIMES = 1.0, 200


def swinging_pendulum():
    return pendulum("thin")[0]


def double_pendulum():
    scene, upper = build_beam("thin", (0, 0), (1, 0), 5, SECTION, MATERIAL)
    lower = scene.add_beam("thin", (1, 0), (2, 0), 5, SECTION, MATERIAL)
    scene.pin(upper.start)
    scene.connect(upper.end, lower.start)
    return scene


def spin_up():
    scene, rod = build_beam("thin", (0, 0), (2, 0), 8, SECTION, MATERIAL, "pin", gravity=(0.0, 0.0))
    scene.point_moment(rod.start, lambda t: 2.0 * math.sin(math.pi * min(t, 1.0)) ** 2)
    return scene


def swinging_cable():
    def across(x):
        return np.stack([0 * x[:, 0], 0.5 * np.sin(np.pi * x[:, 0] / 3), 0 * x[:, 0]], axis=1)

    scene = ancf.Scene((0.0, 0.0, -9.81))
    cable = scene.add_beam("thin", (0, 0, 0), (3, 0, 0), 12, SECTION, MATERIAL, velocity=across)
    scene.pin(cable.start)
    scene.pin(cable.end)
    return scene


def swing():
    board = ancf.Rectangle(0.03, 0.03)
    scene, seat = build_beam("thin", (0, 0), (1, 0), 4, board, MATERIAL, velocity=(1.0, 0.0))
    scene.rod(seat.start, (0.0, 1.0))
    scene.rod(seat.end, (1.0, 1.0))
    return scene


SCENES = [swinging_pendulum, double_pendulum, spin_up, swinging_cable, swing]


def positions(run):
    """All nodes at all saved times, (k, n, dim)."""
    dim = run.system.dim
    return np.concatenate([run.q[:, p[:, :dim]] for p in run.system.places], axis=1)


def fixed(scene, dt, tolerance=1e-4, **options):
    run = ancf.simulate(
        scene,
        T_END,
        dt,
        save_every=round(T_END / TIMES / dt),
        tolerance=tolerance,
        **options,
    )
    return positions(run), run.stats


def distance(found, exact):
    return np.linalg.norm(found - exact, axis=2).max()


def cost(stats):
    """Residuals, and factors at four of them with their solution, as `Costs` weighs them here."""
    return stats.residual_evaluations + 4 * stats.factorizations
