"""Advice after a failed run fits its scene and its integrator."""

import re

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from ancfsparse.solve.error_control.check_accuracy import check_accuracy
from ancfsparse.solve.stepping.remedies import hint_for_accuracy, hint_for_fixed_steps
from ancfsparse.system import System


@pytest.mark.parametrize(
    ("integrator", "damping"),
    [
        (ancf.Newmark(), "GeneralizedAlpha(0.8), or 0.5 for long steps, which"),
        (ancf.GeneralizedAlpha(0.9), "GeneralizedAlpha(0.8), or 0.5 for long steps, which"),
        (ancf.GeneralizedAlpha(0.8), "GeneralizedAlpha(0.5), which"),
        (ancf.HHT(0.1), "GeneralizedAlpha(0.5), which"),
        (ancf.GeneralizedAlpha(0.5), None),
        (ancf.HHT(1 / 3), None),
        (ancf.EnergyMomentum(), "GeneralizedAlpha(0.8), or 0.5 for long steps, which"),
    ],
    ids=repr,
)
def test_no_integrator_is_advised_that_damps_no_more(integrator, damping):
    scene, _ = pendulum("thin")
    for text in (hint_for_fixed_steps(scene, integrator, 0), hint_for_accuracy(scene, integrator)):
        found = re.search(r"integrator=(GeneralizedAlpha.* which)", text)
        assert (found and found[1]) == damping
    keeps = isinstance(integrator, ancf.EnergyMomentum)
    assert ("EnergyMomentum()" in hint_for_fixed_steps(scene, integrator, 0)) != keeps


@pytest.mark.parametrize("metre", [1e-6, 1.0, 1e3])
def test_the_advised_accuracy_fits_the_scene(metre):
    scene = ancf.Scene(gravity=(0.0, -9.81 * metre))
    width = 0.01 * metre
    scene.add_beam("thin", (0, 0), (-1.2 * metre, 1.6 * metre), 4, ancf.Rectangle(width, width),
                   ancf.Material(1e8, 4000.0))  # fmt: skip
    text = hint_for_fixed_steps(scene, ancf.Newmark(), 0)
    accuracy = float(re.search(r"accuracy=(\S+) \[m\] instead of dt\.$", text)[1])
    assert accuracy == pytest.approx(2e-3 * metre, rel=0.3)
    check_accuracy(System(scene), accuracy, "default", None, "auto", 0)


def test_what_is_in_use_or_not_there_is_not_advised():
    scene, rod = pendulum("thin")
    assert "max_halvings=5" in hint_for_fixed_steps(scene, ancf.Newmark(), 0)
    assert "max_halvings" not in hint_for_fixed_steps(scene, ancf.Newmark(), 3)
    assert "loads" not in hint_for_accuracy(scene, ancf.Newmark())
    scene.point_force(rod.end, lambda t: np.array([0.0, np.sin(t)]))
    assert "smooth loads" in hint_for_accuracy(scene, ancf.Newmark())
    assert hint_for_accuracy(scene, ancf.GeneralizedAlpha(0.5)).startswith(
        "Try a smaller accuracy, or"
    )
