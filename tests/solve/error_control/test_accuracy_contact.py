"""Runs to an accuracy in scenes with contact, whose impacts their first steps do not resolve."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ancfsparse as ancf

G, RADIUS, HEIGHT = 9.81, 5e-3, 5e-3  # [m/s2, m, m]
CABLE = ancf.Circle(2.0 * RADIUS), ancf.Material(1e8, 2e3)
MASS = CABLE[1].density * math.pi * RADIUS**2  # [kg/m]
T_END = 0.12  # [s]


def floor(n_elements=10, tilt=0.0, speed=0.0, **contact):
    """A free cable that falls or is thrown onto a floor."""
    scene = ancf.Scene((0.0, -G))
    level = RADIUS + HEIGHT
    end = math.cos(tilt), level + math.sin(tilt)
    cable = scene.add_beam("thin", (0.0, level), end, n_elements, *CABLE, velocity=(speed, 0.0))
    scene.contact(cable, ancf.HalfSpace((0.0, 0.0), (0.0, 1.0)), **contact)
    return scene, cable


def bounces(stiffness, t):
    """Heights of a mass that falls on the law of the pressure, (k,) [m]."""
    layer = 1e-3 * RADIUS

    def pressure(e):
        if e <= 0.0:
            return 0.0
        within = stiffness * (e**3 / layer**2 - e**4 / (2.0 * layer**3))
        return within if e < layer else stiffness * (e - 0.5 * layer)

    motion = solve_ivp(
        lambda _, y: (y[1], pressure(RADIUS - y[0]) / MASS - G),
        (0.0, T_END),
        (RADIUS + HEIGHT, 0.0),
        t_eval=t,
        rtol=1e-10,
        atol=1e-12,
        max_step=1e-5,
    )
    return motion.y[0]


@pytest.mark.parametrize(
    "integrator", ["auto", ancf.GeneralizedAlpha(0.9), ancf.EnergyMomentum(), ancf.DormandPrince()]
)
@pytest.mark.parametrize("accuracy", [1e-3, 1e-4])
def test_a_cable_that_bounces_is_where_a_mass_on_a_spring_is(accuracy, integrator):
    scene, cable = floor()
    run = ancf.simulate(scene, T_END, 1e-3, accuracy=accuracy, integrator=integrator)
    stiffness = next(each.stiffness[0] for each in run.system.contributions if each.is_contact)
    expected = bounces(stiffness, run.t)
    assert expected[60:].max() > RADIUS + 0.9 * HEIGHT  # it returns
    assert np.abs(run.position(cable.at(0.5))[:, 1] - expected).max() < accuracy


@pytest.mark.parametrize(
    ("accuracy", "contact"),
    [
        (1e-3, {"friction": 0.3, "stiffness": 1e6}),
        (1e-4, {"friction": 0.3, "stiffness": 1e6}),
        (1e-3, {"friction": 0.3, "stiffness": 1.3e6, "slip_speed": 1e-2}),
        (1e-4, {"friction": 0.3, "stiffness": 1.3e6, "slip_speed": 1e-2}),
        (1e-3, {"restitution": 0.25, "stiffness": 1.3e6}),
        (1e-4, {"restitution": 0.25, "stiffness": 1.3e6}),
    ],
    ids=[
        "bristles",
        "bristles-fine",
        "slip-speed",
        "slip-speed-fine",
        "restitution",
        "restitution-fine",
    ],
)
def test_a_cable_that_whips_onto_a_floor(accuracy, contact):
    """With friction or restitution, energy alone does not determine an impact."""
    scene, _ = floor(20, 0.05, 1.0, **contact)
    fine = ancf.simulate(scene, T_END, 2e-6, integrator=ancf.GeneralizedAlpha(0.9), save_every=500)
    run = ancf.simulate(scene, T_END, 1e-3, accuracy=accuracy)
    nodes = np.unique(run.system.positions)
    assert np.abs(run.q[:, nodes] - fine.q[:, nodes]).max() < accuracy


def test_a_chaotic_whip_is_not_called_accurate():
    """Runs of 1 and 2 us by three integrators differ by 2 to 5 mm at its end."""
    scene, _ = floor(20, 0.05, 1.0)
    with pytest.raises(ancf.AccuracyError, match="no longer follows the steps"):
        ancf.simulate(scene, T_END, 1e-3, accuracy=1e-3)


@pytest.mark.parametrize(
    ("width", "material", "n", "depth", "stiffness", "t_end", "accuracy"),
    [
        # Errors over the accuracy of runs that two orders agreed on: 14.3, 2.1 and 4.8.
        (0.006235, (3.503e6, 5138.0), 6, 0.3, 301.8, 0.9542, 1.698e-4),
        (0.0221, (1.35e6, 2420.0), 5, 0.05, 6090.0, 0.951, 1.4e-4),
        (0.00974, (2.4e6, 6110.0), 3, 0.3, 6010.0, 0.54, 3.96e-4),
    ],
)
def test_two_orders_that_agree_by_chance_are_not_called_accurate(
    width, material, n, depth, stiffness, t_end, accuracy
):
    def cantilever():
        scene = ancf.Scene((0.0, -G))
        section = ancf.Rectangle(width, width)
        rod = scene.add_beam("thin", (0, 0), (1, 0), n, section, ancf.Material(*material))
        scene.clamp(rod.start)
        floor = ancf.HalfSpace((0.0, -depth - 0.02), (0.0, 1.0))
        scene.contact(rod, floor, stiffness=stiffness, radius=0.02)
        return scene, rod.end

    scene, tip = cantilever()
    fine = {"dt": t_end / 20000, "integrator": ancf.RungeKuttaNystrom(4), "save_every": 1000}
    expected = ancf.simulate(scene, t_end, **fine).position(tip)
    scene, tip = cantilever()
    run = ancf.simulate(scene, t_end, t_end / 20, accuracy=accuracy)
    assert np.abs(run.position(tip) - expected).max() < accuracy
