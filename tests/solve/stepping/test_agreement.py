"""Every way to solve the equations of a step gives one motion, at the cost it promises."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import pendulum

UPDATES = ("broyden", "davidon", "dfp", "bfgs")
SOLVERS = {
    "modified newton": ancf.ModifiedNewton(),
    "auto": "auto",
    **{u: ancf.QuasiNewton(u) for u in UPDATES},
    **{f"{u}, 10 pairs": ancf.QuasiNewton(u, 10) for u in UPDATES},
    **{f"{u}, 10 pairs carried": ancf.QuasiNewton(u, 10, carry=True) for u in UPDATES},
    **{f"{u}, differences": ancf.QuasiNewton(u, seed="finite-difference") for u in UPDATES},
}
T_END, DT, TIGHT = 2.0, 5e-4, 1e-9


def run(solver, tolerance, element="l2t2", dt=DT, t_end=T_END, save_every=10, **options):
    scene, rod = pendulum(element, **options)
    found = ancf.simulate(
        scene, t_end, dt, solver=solver, tolerance=tolerance, save_every=save_every,
        integrator=ancf.Newmark(),
    )  # fmt: skip
    return found.position(rod.end), found


@pytest.fixture(scope="module")
def newton():
    """Tip of a tightly converged Newton run, every tenth step."""
    return {name: run(ancf.Newton(), TIGHT, name)[0] for name in ("l2t2", "thin")}


ON_CABLES = ("modified newton", "auto", "davidon", "bfgs, 10 pairs carried")


@pytest.mark.parametrize(
    ("name", "element"), [*((n, "l2t2") for n in SOLVERS), *((n, "thin") for n in ON_CABLES)]
)
def test_all_solvers_agree_when_tight(name, element, newton):
    tip, _ = run(SOLVERS[name], TIGHT, element)
    assert np.abs(tip - newton[element]).max() < 1e-8


@pytest.mark.parametrize(
    "name",
    ["newton", "modified newton", *UPDATES, *(f"{update}, 10 pairs" for update in UPDATES)],
)
def test_all_solvers_agree_at_the_papers_tolerance(name, newton):
    solver = ancf.Newton() if name == "newton" else SOLVERS[name]
    tip, _ = run(solver, "paper")
    assert np.abs(tip - newton["l2t2"]).max() < 1e-7


@pytest.mark.parametrize(
    ("update", "element", "dt"),
    [
        ("broyden", "l2t2", 1e-3),
        ("davidon", "thin", 1e-3),
        ("dfp", "l2t2", 6.25e-5),
        ("bfgs", "thin", 6.25e-5),
    ],
)
def test_full_memory_agrees_at_other_steps(update, element, dt):
    stride = round(0.05 / dt)
    expected, _ = run(ancf.Newton(), TIGHT, element, dt, 0.5, stride)
    tip, _ = run(ancf.QuasiNewton(update), TIGHT, element, dt, 0.5, stride)
    assert np.abs(tip - expected).max() < 1e-8


def test_the_default_tolerance_stays_below_the_error_of_the_step(newton):
    # At 5e-4 s the trapezoidal rule is 4e-6 m off at t = 0.5 s (numerics), more later.
    for solver in ("auto", ancf.Newton(), ancf.ModifiedNewton()):
        tip, _ = run(solver, "default", "thin")
        assert np.abs(tip - newton["thin"]).max() < 1e-5


def test_davidon_needs_few_iterations_on_the_papers_pendulum():
    _, found = run(ancf.QuasiNewton("davidon"), "paper")
    assert found.stats.steps == 4000
    assert found.stats.iterations_per_step <= 2.6
    assert found.stats.recoveries == 0


@pytest.mark.parametrize("update", UPDATES)
def test_full_memory_beats_the_chord_on_an_old_seed(update):
    # One factor for 4000 steps, in fewer iterations than the 12 of a chord (numerics 1.5).
    _, found = run(ancf.QuasiNewton(update), "paper")
    assert found.stats.factorizations == 1
    assert found.stats.iterations_per_step < 4.5


def test_newton_needs_one_correction_when_steps_are_small():
    _, found = run(ancf.Newton(), "paper")
    assert found.stats.iterations_per_step == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("strain", ["green", "biot"])
def test_a_spatial_cable_swings_like_a_planar_one(strain):
    planar, _ = run(ancf.Newton(), TIGHT, "thin", strain=strain)
    spatial, _ = run(ancf.Newton(), TIGHT, "thin", dim=3, strain=strain)
    np.testing.assert_allclose(spatial[:, :2], planar, rtol=0, atol=1e-10)
    assert np.abs(spatial[:, 2]).max() < 1e-14


def test_a_thick_beam_in_the_plane_swings_like_one_in_space():
    tips = [
        run(ancf.Newton(), TIGHT, "thick", t_end=0.5, dim=dim, section_strain="nodal")[0][:, :2]
        for dim in (2, 3)
    ]
    np.testing.assert_allclose(tips[1], tips[0], rtol=0, atol=1e-9)


def test_the_thick_pendulum_is_locked_by_its_section_and_freed_by_nodal_strains():
    # nu = 0: -1.2554 m with 10 elements, -1.20505 with nodal section strains; thin: -1.20293.
    found = [
        run(ancf.Newton(), 1e-6, "thick", t_end=0.5, save_every=1000, nu=0.0, section_strain=s)
        for s in ("consistent", "nodal")
    ]
    heights = [tip[-1, 1] for tip, _ in found]
    assert heights[0] == pytest.approx(-1.2554, abs=1e-4)
    assert heights[1] == pytest.approx(-1.20505, abs=2e-5)


def test_the_thick_pendulum_with_poissons_ratio():
    tip, _ = run(ancf.Newton(), 1e-6, "thick", t_end=0.5, save_every=1000, nu=0.3)
    assert tip[-1, 1] == pytest.approx(-1.25883, abs=2e-5)


def test_auto_weighs_a_dense_inverse_against_sweeps_and_says_why():
    _, cable = run("auto", "paper", t_end=0.01)
    assert "modified Newton with a sparse factorization: 42 unknowns" in cable.stats.solver
    scene, _ = pendulum("thick", 4)
    full = ancf.simulate(scene, 0.01, 5e-4)
    assert "bfgs, full memory" in full.stats.solver
    scene, rod = pendulum("thick", 4)
    scene.rod(rod.end, (2.0, 1.0, 0.0))  # its direction turns, so curvatures may be negative
    turning = ancf.simulate(scene, 0.01, 5e-4)
    assert "davidon, full memory" in turning.stats.solver


def test_memory_that_is_not_needed_makes_no_difference():
    # Pairs of this step only: a memory that never fills is a full one as long as the step lasts.
    found = [
        run(ancf.QuasiNewton("davidon", pairs), TIGHT, t_end=0.2, save_every=1)[0]
        for pairs in (25, 200)
    ]
    np.testing.assert_array_equal(found[0], found[1])
