"""Rates that are given with a prescribed motion are its derivatives, or refused."""

from __future__ import annotations

import numpy as np
import pytest

import ancfsparse as ancf

W = 300.0  # of a vibration that is far shorter than the run [rad/s]
CUBE = (lambda t: t**3, lambda t: 3 * t**2, lambda t: 6 * t)
SHAKE = (
    lambda t: 1e-3 * np.sin(W * t) ** 3,
    lambda t: 3e-3 * W * np.sin(W * t) ** 2 * np.cos(W * t),
    lambda t: 3e-3 * W**2 * (2 * np.sin(W * t) * np.cos(W * t) ** 2 - np.sin(W * t) ** 3),
)


def support(motion, rate, second_rate):
    scene = ancf.Scene()
    section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000)
    rod = scene.add_beam("thin", (0, 0), (1, 0), 2, section, material)
    upwards = [(lambda t, f=f: (0.0, f(t))) for f in (motion, rate, second_rate)]
    scene.drive(rod.start, upwards[0], rate=upwards[1], second_rate=upwards[2])
    return scene


def angle(shape):
    def build(motion, rate, second_rate):
        scene = ancf.Scene()
        inertia = {"centre": (0.5, 0), "inertia": 0.2} if shape is None else {}
        body = scene.add_body(shape, position=(0, 0), mass=2.0, **inertia)
        scene.drive_joint(scene.pin(body.origin), motion, rate=rate, second_rate=second_rate)
        return scene

    return build


def length(connect):
    def build(motion, rate, second_rate):
        scene = ancf.Scene(gravity=(0, 0))
        body = scene.add_body(position=(1, 0), mass=2.0, inertia=0.2)
        rates = {"rate": rate, "second_rate": second_rate}
        connect(scene, body.origin, length=lambda t: 1.0 + motion(t), **rates)
        return scene

    return build


def tie(scene, point, **motion):
    wall = scene.add_body(position=(0, 0), mass=1.0, inertia=1.0)
    scene.clamp(wall.origin)
    scene.distance(wall.origin, point, **motion)


SCENES = {
    "support": support,
    "rod": angle(ancf.Rod(1.0)),
    "body": angle(None),
    "length of a rod": length(lambda scene, point, **motion: scene.rod(point, (0, 0), **motion)),
    "winch": length(lambda scene, point, **motion: scene.winch([(0, 0), point], **motion)),
    "distance": length(tie),
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("motion", [CUBE, SHAKE], ids=["cube", "shake"])
@pytest.mark.parametrize(
    ("factors", "words"),
    [
        ((1.01, 1.0), r"the rate of the \w+ .* at t = .* differences of the "),
        ((-1.0, 1.0), "the rate of the"),
        ((180 / np.pi, 1.0), "the rate of the"),
        ((1.0, 0.5), "the second rate of the .* differences of the rate of"),
    ],
)
@pytest.mark.parametrize("accuracy", [None, 1e-4])
def test_a_rate_that_is_not_the_derivative_is_refused(name, motion, factors, words, accuracy):
    place, *right = motion
    wrong = [(lambda t, c=c, f=f: c * f(t)) for c, f in zip(factors, right, strict=True)]
    options = {"dt": 1e-3} if accuracy is None else {"accuracy": accuracy}
    with pytest.raises(ancf.InputError, match=words):
        ancf.simulate(SCENES[name](place, *wrong), 1.0, **options)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("motion", [CUBE, SHAKE], ids=["cube", "shake"])
@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.DormandPrince()], ids=repr)
def test_a_rate_that_is_the_derivative_is_taken(name, motion, integrator):
    run = ancf.simulate(SCENES[name](*motion), 0.1, 1e-4, integrator=integrator)
    assert run.finished


def test_rates_by_differences_of_the_user_are_taken():
    place, h = CUBE[0], 1e-5
    rate = lambda t: (place(t + h) - place(t - h)) / (2 * h)  # noqa: E731
    second_rate = lambda t: (place(t + h) - 2 * place(t) + place(t - h)) / h**2  # noqa: E731
    assert ancf.simulate(support(place, rate, second_rate), 0.1, 1e-3).finished
