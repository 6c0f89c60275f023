"""Errors predicted from the vibrations of a scene, against those of runs."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.error_models.modal_spectrum import MAX_COORDINATES, ModalSpectrum
from ancfsparse.solve.error_models.step_count_selection import (
    EXTRA_STEPS,
    MIN_STEPS,
    SAFETY_FACTOR,
    StepPlan,
    min_steps,
)
from ancfsparse.solve.stepping.sampled_states import SampledStates
from ancfsparse.system import System
from benchmarks.random_scenes.scenes import SAVED, distance, make, positions, reference

SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)
T_END = 0.2
END = (0.8, -0.6)  # oblique, so that weight sets off waves along the rod and across it


def rod(n=5, gravity=-9.81, **options):
    scene = ancf.Scene((0.0, gravity))
    beam = scene.add_beam("thin", (0, 0), END, n, SECTION, MATERIAL, **options)
    return scene, beam


def clamped():
    scene, beam = rod()
    scene.clamp(beam.start, stretch="fixed")
    return scene


def swinging():
    scene, beam = rod(
        velocity=lambda x: (
            np.stack([0 * x[:, 0], 0.2 * x[:, 0]], axis=1) @ [[0.8, -0.6], [0.6, 0.8]]
        )
    )
    scene.pin(beam.start)
    return scene


def struck():
    scene, beam = rod()
    scene.pin(beam.start)
    scene.point_force(beam.end, lambda t: (0.0, 2.0 if t >= 0.1 else 0.0))
    return scene


def hanging():
    scene, beam = rod()
    scene.rod(beam.start, (0.0, 1.0))
    return scene


def waves_of(scene):
    system = System(scene)
    discontinuities = LoadDiscontinuities(system, 0.0, T_END)
    return ModalSpectrum.of(system, discontinuities, T_END), discontinuities


def tips(scene, steps, integrator):
    run = ancf.simulate(
        scene, T_END, T_END / steps, save_every=steps // 20, integrator=integrator,
        max_energy_gain=np.inf,
    )  # fmt: skip
    return run.position(scene.beams[0].end)


@pytest.mark.parametrize("make", [clamped, swinging, hanging])
def test_the_error_of_explicit_runs_is_predicted_not_much_too_small(make):
    spectrum, _ = waves_of(make())
    exact = tips(make(), 8000, ancf.DormandPrince())
    methods = [ancf.DormandPrince()]
    if make is not hanging:
        methods += [ancf.CentralDifference(), ancf.RungeKuttaNystrom(4), ancf.RungeKuttaNystrom(8)]
    for method in methods:
        limit = ancf.stable_step(make(), method)
        for finer in (1.1, 2.0):
            steps = 20 * int(np.ceil(T_END / limit * finer / 20))
            error = np.linalg.norm(tips(make(), steps, method) - exact, axis=1).max()
            predicted = spectrum.error((method, T_END / steps))
            assert predicted / 50.0 < error < 5.0 * predicted or error < 1e-11


@pytest.mark.parametrize("make", [clamped, swinging, hanging])
def test_the_error_of_implicit_runs_is_predicted_within_a_factor_of_five(make):
    spectrum, discontinuities = waves_of(make())
    integrator = ancf.GeneralizedAlpha(0.9)
    exact = tips(make(), 8000, ancf.DormandPrince())
    assert min_steps(discontinuities, T_END) == MIN_STEPS
    for steps in (100, 400, 1600):
        error = np.linalg.norm(tips(make(), steps, integrator) - exact, axis=1)
        predicted = spectrum.error((integrator, T_END / steps))
        assert predicted / 5.0 < error.max() < 5.0 * predicted


def test_a_jump_sets_off_waves_for_the_time_after_it():
    spectrum, _ = waves_of(struck())
    calm, _ = waves_of(swinging())
    n = len(calm.omega)
    assert len(spectrum.omega) == 2 * n
    np.testing.assert_allclose(spectrum.time[n:], 0.1, rtol=1e-6)
    np.testing.assert_allclose(spectrum.time[:n], T_END)
    assert spectrum.amplitude[n:].max() > 1e-4


def test_damping_ends_waves_and_creeping_ones_are_none():
    scene = ancf.Scene((0.0, -9.81))
    wet = ancf.Material(1e8, 4000.0, axial_damping=1e-3, bending_damping=1e-3)
    scene.clamp(scene.add_beam("thin", (0, 0), END, 5, SECTION, wet).start, stretch="fixed")
    spectrum, _ = waves_of(scene)
    dry, _ = waves_of(clamped())
    assert len(spectrum.omega) < len(dry.omega)
    # C = tau K: vibrations of omega tau < 2, which last for 2 / (omega^2 tau).
    assert spectrum.omega.max() < 2000.0
    np.testing.assert_allclose(spectrum.time, np.minimum(T_END, 2e3 / spectrum.omega**2), rtol=1e-6)


def test_what_is_not_known_is_none():
    scene, beam = rod(n=MAX_COORDINATES // 4 + 1)
    scene.pin(beam.start)
    assert waves_of(scene)[0] is None
    for gravity, expected in ((0.0, True), (-9.81, False)):
        scene, beam = rod(gravity=gravity)
        scene.pin(beam.start)
        scene.point_force(beam.end, lambda t: (0.0, 0.1 * np.sin(3 * t) ** 2))
        assert (waves_of(scene)[0] is None) == expected, gravity
    assert waves_of(rod(gravity=0.0)[0])[0] is None  # at rest


def test_runs_that_dissipate_the_same_waves_do_not_see_them():
    spectrum, _ = waves_of(clamped())
    method = ancf.RungeKuttaNystrom(4)
    limit = ancf.stable_step(clamped(), method)
    far = (method, 0.95 * limit), (method, 0.8 * limit)
    assert spectrum.common_error(*far) > 0.3 * spectrum.error(far[1])
    near = (method, 0.1 * limit), (method, 0.08 * limit)
    assert spectrum.common_error(*near) < 0.05 * spectrum.error(near[1])


WAVE = ModalSpectrum(*np.array([[1e-2], [50.0], [1.0]]))


def in_steps(steps):
    return ancf.Newmark(0.0), 1.0 / steps


def test_the_errors_of_one_vibration():
    coarse, middle, fine = map(in_steps, (2000, 4000, 8000))
    z = 50.0 / 4000
    assert WAVE.error(middle) == pytest.approx(1e-2 * 50.0 * z**2 / 12.0, rel=1e-3)
    assert WAVE.error(in_steps(10)) == 1e-2  # its phase is lost
    assert WAVE.difference(coarse, middle) == pytest.approx(3.0 * WAVE.error(middle), rel=1e-3)
    # What is left without the second power falls with the fourth.
    errors = [WAVE.extrapolated_error(*pair) for pair in ((coarse, middle), (middle, fine))]
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.1)
    assert errors[1] < 0.01 * WAVE.error(fine)


def test_the_vibration_that_makes_two_runs_differ():
    coarse, fine = in_steps(2000), in_steps(4000)
    found = ModalSpectrum.of_difference(WAVE.difference(coarse, fine), 50.0, 1.0, coarse, fine)
    np.testing.assert_allclose(found.amplitude, WAVE.amplitude, rtol=1e-12)
    assert found.scale(2e-5, coarse, fine) == pytest.approx(2e-5 / found.difference(coarse, fine))


@pytest.mark.parametrize("accuracy", [1e-3, 1e-5, 1e-7])
def test_plans_end_with_the_accuracy(accuracy):
    plan = StepPlan(WAVE, ancf.Newmark(0.0), 1.0, 10.0)

    def error(runs):
        schemes = [in_steps(steps) for steps in runs[-2:]]
        return WAVE.error(*schemes) if len(runs) == 1 else WAVE.extrapolated_error(*schemes)

    first, total = plan.first(accuracy)
    runs, spent = [first], first + EXTRA_STEPS
    while True:
        enough = error(runs[-1:]) <= SAFETY_FACTOR * accuracy
        if len(runs) > 2:
            enough |= error(runs) <= SAFETY_FACTOR * accuracy
        if enough and len(runs) > 1:
            break
        runs.append(plan.next(runs[-2:], accuracy)[0])
        spent += runs[-1] + EXTRA_STEPS
        assert len(runs) < 8
    assert spent == pytest.approx(total, rel=0.1)
    assert error([runs[-1] / 1.2]) > SAFETY_FACTOR * accuracy or len(runs) > 2


def test_vibrations_that_others_set_off_are_found_in_a_run():
    case = make(0)
    system = System(case.scene)
    start = ModalSpectrum.of(system, LoadDiscontinuities(system, 0.0, case.t_end), case.t_end)
    exact, _ = reference(case)
    method = ancf.RungeKuttaNystrom(4)
    limit = ancf.stable_step(case.scene, method)
    runs = []
    for finer in (2.0, 4.0):
        every = math.ceil(case.t_end / limit * finer / SAVED)
        dt = case.t_end / SAVED / every
        run = ancf.simulate(case.scene, case.t_end, dt, save_every=every, integrator=method)
        runs.append((run, dt, distance(positions(system, run.q), exact)))
    first = runs[0][0]
    states = SampledStates(first.t, first.q, first.v, first.a, first.lam, first.internal)
    during = ModalSpectrum.during(system, states)
    for _, dt, error in runs:
        assert start.error((method, dt)) < 0.3 * error
        assert 0.5 * error < during.error((method, dt)) < 4.0 * error
