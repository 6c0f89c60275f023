"""Order of convergence in time, against motions that are known exactly in time."""

import tomllib

import numpy as np
import pytest
from scipy.optimize import brentq

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from tests.integrators.points import orders
from tests.paths import REFERENCES

TIPS = tomllib.loads((REFERENCES / "pendulum.toml").read_text(encoding="utf-8"))
ROOTS = tomllib.loads((REFERENCES / "vibration.toml").read_text(encoding="utf-8"))
ELEMENTS = {"l2t2": ("l2t2", {}), "green": ("thin", {}), "biot": ("thin", {"strain": "biot"})}
TIGHT = 1e-9
STEPS = [1.25e-4 / 2**k for k in range(5)]


def tips(name, dt, solver, alpha=0.0, t_end=0.5, tolerance=TIGHT):
    """Tip positions at 0.5 s and its multiples."""
    element, options = ELEMENTS[name]
    scene, rod = pendulum(element, **options)
    run = ancf.simulate(
        scene, t_end, dt, solver=solver, tolerance=tolerance, integrator=ancf.Newmark(alpha),
        save_every=round(0.5 / dt),
    )  # fmt: skip
    return run.position(rod.end)[1:]


@pytest.mark.parametrize("name", ELEMENTS)
def test_the_trapezoidal_rule_is_of_second_order(name):
    exact = np.array([TIPS["tip"][name]["0.5"]])
    found = np.array([tips(name, dt, ancf.Newton()) for dt in STEPS])
    errors = np.abs(found - exact).max(axis=(1, 2))
    assert np.abs(orders(errors) - 2).max() < 0.1
    assert errors[-1] < TIPS["tolerance"]
    # The error is a series in dt^2: once extrapolated it is of fourth order, and far below 1e-8.
    once = (4 * found[1:] - found[:-1]) / 3
    twice = (16 * once[1:] - once[:-1]) / 15
    assert np.abs(once[-1] - exact).max() < TIPS["tolerance"] / 100
    assert np.abs(twice[-1] - exact).max() < 5e-12


@pytest.mark.parametrize("name", ELEMENTS)
def test_one_second_is_as_exact_as_half(name):
    exact = [TIPS["tip"][name]["0.5"], TIPS["tip"][name]["1.0"]]
    found = np.array([tips(name, dt, ancf.Newton(), t_end=1.0) for dt in (6.25e-5, 3.125e-5)])
    errors = np.abs(found - exact).max(axis=(1, 2))
    assert np.abs(orders(errors) - 2).max() < 0.1
    extrapolated = (4 * found[1] - found[0]) / 3
    assert np.abs(extrapolated - exact).max() < TIPS["tolerance"]


@pytest.mark.parametrize("update", ["broyden", "davidon", "dfp", "bfgs"])
@pytest.mark.parametrize("name", ELEMENTS)
def test_quasi_newton_converges_to_the_same_motion(name, update):
    exact = np.array([TIPS["tip"][name]["0.5"]])
    errors = [np.abs(tips(name, dt, ancf.QuasiNewton(update)) - exact).max() for dt in STEPS]
    # At the last step the rounding of the corrections shows: it is above the tolerance asked for.
    assert np.abs(orders(errors[:4]) - 2).max() < 0.1
    assert errors[-1] < TIPS["tolerance"]


def test_the_default_method_at_its_default_tolerance_is_of_second_order_too():
    # What a person gets who says nothing: the iteration must not spoil the order of the method.
    exact = np.array([TIPS["tip"]["green"]["0.5"]])
    errors = [
        np.abs(tips("green", dt, "auto", tolerance="default") - exact).max() for dt in STEPS[:3]
    ]
    assert np.abs(orders(errors) - 2).max() < 0.15
    assert errors[0] < 5e-6


def test_the_mesh_converges_to_its_limit():
    limit = TIPS["mesh_limit"]["green"]
    scene, rod = pendulum("thin", 40)
    found = [
        ancf.simulate(scene, 0.5, dt, solver=ancf.Newton(), save_every=round(0.5 / dt)).position(
            rod.end
        )[-1]
        for dt in (1.25e-4, 6.25e-5)
    ]
    extrapolated = (4 * found[1] - found[0]) / 3
    assert np.abs(extrapolated - limit["0.5"]).max() < 20 * limit["tolerance"]


@pytest.mark.parametrize("alpha", [0.05, 0.3])
def test_damping_makes_it_first_order(alpha):
    exact = np.array([TIPS["tip"]["green"]["0.5"]])
    errors = [np.abs(tips("green", dt, ancf.Newton(), alpha) - exact).max() for dt in STEPS[:4]]
    assert np.abs(orders(errors) - 1).max() < 0.1


def test_damping_loses_energy_and_the_trapezoidal_rule_does_not():
    scene, _ = pendulum("thin")
    lost = []
    for alpha in (0.0, 0.05, 0.3):
        run = ancf.simulate(
            scene, 1.0, 5e-4, integrator=ancf.Newmark(alpha), solver=ancf.Newton(), tolerance=TIGHT
        )
        energy = run.energy
        lost.append((energy.total[0] - energy.total[-1]) / energy.kinetic.max())
    assert abs(lost[0]) < 2e-5
    assert 1e-4 < lost[1] < lost[2] < 1e-1


FREE = {"pinned_free": lambda x: np.tan(x) - np.tanh(x),
        "clamped_free": lambda x: np.cos(x) * np.cosh(x) + 1}  # fmt: skip


@pytest.mark.parametrize("support", FREE)
def test_the_roots_are_roots(support):
    for root in ROOTS[support]["roots"]:
        found = brentq(FREE[support], root - 0.05, root + 0.05, xtol=1e-13)
        assert found == pytest.approx(root, abs=ROOTS[support]["tolerance"])


def shape(support, beta, x, length):
    """Mode shapes of Euler and Bernoulli."""
    if support == "pinned_free":
        ratio = np.sin(beta * length) / np.sinh(beta * length)
        return np.sin(beta * x) + ratio * np.sinh(beta * x)
    ratio = (np.cos(beta * length) + np.cosh(beta * length)) / (
        np.sin(beta * length) + np.sinh(beta * length)
    )
    return np.cosh(beta * x) - np.cos(beta * x) - ratio * (np.sinh(beta * x) - np.sin(beta * x))


CASES = [(s, k) for s in FREE for k in range(len(ROOTS[s]["roots"]))]


@pytest.mark.parametrize(("support", "k"), CASES)
@pytest.mark.parametrize("name", ["l2t2", "green", "biot"])
def test_small_vibrations_have_the_frequencies_of_euler_and_bernoulli(name, support, k):
    length, n_elements, per_period = 2.0, 16, 100
    section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(2e11, 8000.0)
    root = brentq(
        FREE[support], *(ROOTS[support]["roots"][k] + np.array([-0.01, 0.01])), xtol=1e-14
    )
    beta = root / length
    omega = beta**2 * np.sqrt(material.youngs_modulus * section.inertia_z
                              / (material.density * section.area))  # fmt: skip
    amplitude = 1e-6 * length

    def velocity(x):
        speed = amplitude * omega * shape(support, beta, x[:, 0], length)
        return np.stack([0 * speed, speed], axis=1)

    element, options = ELEMENTS[name]
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam(
        element, (0, 0), (length, 0), n_elements, section, material, velocity=velocity, **options
    )
    if support == "pinned_free":
        scene.pin(rod.start)
    else:
        scene.clamp(rod.start)
    dt = 2 * np.pi / omega / per_period
    run = ancf.simulate(
        scene, 200 * dt, dt, solver=ancf.Newton(), tolerance=TIGHT, integrator=ancf.Newmark()
    )
    y = run.position(rod.end)[:, 1]
    assert np.abs(y).max() > amplitude
    # One frequency obeys y[k+1] + y[k-1] = 2 cos(omega dt) y[k]; trapezoidal: tan(w dt / 2) is
    # omega dt / 2 with the true omega.
    cosine = 0.5 * np.sum(y[1:-1] * (y[2:] + y[:-2])) / np.sum(y[1:-1] ** 2)
    found = 2 / dt * np.tan(0.5 * np.arccos(cosine))
    # A cubic element of length l is too stiff by (beta l)^4 / 1440 in omega.
    mesh = (beta * length / n_elements) ** 4 / 1440
    assert found == pytest.approx(omega * (1 + mesh), rel=0.2 * mesh + 2e-6)
