"""What models neglect of natural frequencies, beside richer models and Timoshenko's theory."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.model_error.neglected_energies import neglected_effects
from ancfsparse.plans.trial_runs.trial_runs import as_trajectory
from tests.beams import build_beam

STEEL = ancf.Material(youngs_modulus=2e11, density=7800.0, poisson_ratio=0.3)
SHEARED = {"curvature": "section", "section_strain": "nodal"}


def beam_of(element, dim, length, ends, n_elements, section=None, **options):
    section = section or (ancf.Circle(0.02) if dim == 3 else ancf.Rectangle(0.02, 0.02))
    axis = np.eye(dim)[0] * length
    options["gravity"] = 0.0 * axis
    return build_beam(element, 0.0 * axis, axis, n_elements, section, STEEL, *ends, **options)


def converged(element, dim, length, ends, number, section=None, **options):
    """Return a frequency without the error of the mesh, which is of order 2 [Hz]."""
    f = []
    for n in (30, 60):
        scene, _ = beam_of(element, dim, length, ends, n, section, **options)
        taut = ancf.solve_static(scene) if "tension" in options else None
        f.append(ancf.modes(scene, number, at=taut).frequencies[-1])
    return f[1] + (f[1] - f[0]) / 3.0


def effects_on(scene, number):
    quantity = ancf.frequency(number).in_scene(scene)
    return neglected_effects(as_trajectory(ancf.solve_static(scene)), quantity)


@pytest.mark.parametrize("number", [1, 3])
@pytest.mark.parametrize("length", [0.4, 1.0])
@pytest.mark.parametrize("ends", [("clamp", ""), ("clamp", "clamp"), ("pin", "pin")])
@pytest.mark.parametrize("dim", [2, 3])
def test_shear_and_rotary_inertia_of_cables(dim, ends, length, number):
    scene, _ = beam_of("thin", dim, length, ends, 24)
    cable = ancf.modes(scene, number).frequencies[-1]
    spin = int(dim == 3 and ends == ("pin", "pin"))  # a beam also turns about its own axis
    true = cable - converged("thick", dim, length, ends, number + spin, **SHEARED)
    error_model = effects_on(scene, number)
    assert sum(error_model.values()) == pytest.approx(true, rel=0.2)
    assert error_model.get("torsion", 0.0) == pytest.approx(0.0, abs=1e-9 * cable)


def test_a_pinned_cable_compared_with_timoshenko():
    """First order of his theory: f lower by (n pi r / L)^2 / 2 (1 + E / k G), r^2 = I / A."""
    scene, rod = beam_of("thin", 2, 1.0, ("pin", "pin"), 16)
    given = rod.stiffnesses()
    slender = (np.pi**2 / 2.0) * 0.02**2 / 12.0
    stiff = given["bending_stiffness"] / (0.02**2 / 12.0) / given["shear_stiffness_y"]
    error_model, frequency = effects_on(scene, 1), ancf.modes(scene, 1).frequencies[0]
    assert error_model["rotary inertia"] == pytest.approx(slender * frequency, rel=0.01)
    assert error_model["shear"] == pytest.approx(slender * stiff * frequency, rel=0.03)


def test_places_that_change():
    """Shear brings the third bending mode below the first stretching one."""
    scene, _ = beam_of("thin", 2, 0.2, ("clamp", "clamp"), 24)
    rich, _ = beam_of("thick", 2, 0.2, ("clamp", "clamp"), 60, **SHEARED)
    f, true = ancf.modes(scene, 4).frequencies, ancf.modes(rich, 3).frequencies
    assert f[2] == pytest.approx(np.sqrt(2e11 / 7800.0) / 0.4, rel=1e-3)  # stretching
    assert f[2] - true[2] < 0.6 * (f[3] - true[2])
    assert f[2] - true[2] <= sum(effects_on(scene, 3).values()) < 2.0 * (f[2] - true[2])


def test_cables_do_not_show_vibrations_of_twist():
    scene, _ = beam_of("thin", 3, 0.2, ("pin", "pin"), 24)
    assert "torsion" not in {k for k, x in effects_on(scene, 1).items() if x > 1e-9}
    # 3977 Hz, and the first of twist 8100 Hz, clamped-free 4050 Hz
    error_model = effects_on(scene, 3)
    assert error_model["torsion"] == pytest.approx(ancf.modes(scene, 3).frequencies[-1])


@pytest.mark.parametrize("number", [1, 3])
@pytest.mark.parametrize("tension", [1e3, 1e4])
def test_bending_of_strings(tension, number):
    given = (2, 2.0, ("pin", "pin"), number, ancf.Rectangle(0.005, 0.005))
    f = [converged(each, *given, tension=tension) for each in ("string", "thin")]
    scene, _ = beam_of("string", 2, 2.0, ("pin", "pin"), 40, given[4], tension=tension)
    assert effects_on(scene, number)["bending"] == pytest.approx(f[1] - f[0], rel=0.25)


@pytest.mark.parametrize(
    ("dim", "length", "section", "number", "element"),
    [
        (2, 1.0, None, 1, "thin"),
        (2, 0.15, None, 1, "thick"),
        (3, 1.0, ancf.Rectangle(0.02, 0.04), 2, None),
    ],
    ids=["slender", "short", "out of the plane"],
)
def test_planned_frequencies_are_those_of_thick_beams(dim, length, section, number, element):
    """The second one of a bar with sides 1 and 2 is that of bending the other way."""
    given = dim, length, ("clamp", "clamp")
    scene, _ = beam_of("auto", *given, "auto", section)
    plan = ancf.plan(scene, quantity=ancf.frequency(number), error="1 %")
    run = plan.run()
    frequency = plan.predictions[0].goal.quantity.value(run)[0, 0]
    rich, _ = beam_of("thick", *given, 100 if dim == 2 else 60, section, **SHEARED)
    exact = ancf.modes(rich, number).frequencies
    assert frequency == pytest.approx(exact[-1], rel=0.01)
    assert exact[-1] < 2.1 * exact[0]
    assert element in (None, run.system.scene.beams[0].element)
