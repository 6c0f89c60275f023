"""A cart with a flexible pole, pushed along a rail."""

import numpy as np
from scipy.linalg import solve_continuous_are

import ancfsparse as ancf

DT, LENGTH = 1e-3, 1.0  # s, m
CART, DENSITY, DIAMETER = 1.0, 1e3, 0.012  # kg, kg/m3, m


def gains():
    """Return the linear-quadratic regulator of a cart with a rigid pole that leans a little."""
    pole = DENSITY * np.pi * DIAMETER**2 / 4 * LENGTH
    # (M + m) x'' + m L/2 w' = F, x'' m L/2 + m L^2/3 w' = m g L/2 lean
    mass = np.array([[CART + pole, pole * LENGTH / 2], [pole * LENGTH / 2, pole * LENGTH**2 / 3]])
    inverse = np.linalg.inv(mass)
    a, b = np.zeros((4, 4)), np.zeros((4, 1))
    a[0, 1] = a[2, 3] = 1.0
    a[[1, 3], 2] = inverse[:, 1] * pole * 9.81 * LENGTH / 2
    b[[1, 3], 0] = inverse[:, 0]
    return -(b.T @ solve_continuous_are(a, b, np.diag([1.0, 0.1, 1.0, 0.1]), np.eye(1)))[0]


GAINS = gains()


def cart_with_pole():
    """Return the scene, the push on the cart [N], the cart, and the pole, which leans a little."""
    push = ancf.Input(2, name="push")
    scene = ancf.Scene((0, -9.81))
    cart = scene.add_body(ancf.Rod(0.3), mass=CART, position=(0, 0))
    tip = LENGTH * np.array([np.sin(0.05), np.cos(0.05)])
    pole = scene.add_beam(
        "thin", (0, 0), tip, 4, ancf.Circle(DIAMETER), ancf.Material(2e10, DENSITY), rest="straight"
    )
    scene.prismatic(cart.origin, axis=(1, 0))
    scene.connect(cart.origin, pole.start)
    scene.point_force(cart.origin, push)
    return scene, push, cart, pole


def observe(cart, pole):
    """Return the functions that observe the positions and velocities of cart and tip."""
    return [
        lambda sim: sim.position(cart.origin)[0],
        lambda sim: sim.velocity(cart.origin)[0],
        lambda sim: sim.position(pole.end),
        lambda sim: sim.velocity(pole.end)[0],
    ]


def balance(observation):
    """Return the push of a linear feedback of the lean and the motion of the cart, (1,)."""
    x, speed, tip, height, tip_speed = observation
    lean = np.arctan2(tip - x, height)
    rate = (tip_speed - speed) / LENGTH
    return np.clip([GAINS @ [x, speed, lean, rate]], -20.0, 20.0)
