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


@pytest.fixture(scope="module")
def papers():
    """Runs at the tolerance of the paper, by the names of their solvers."""
    names = ["modified newton", *UPDATES, *(f"{update}, 10 pairs" for update in UPDATES)]
    solvers = {"newton": ancf.Newton(), **{name: SOLVERS[name] for name in names}}
    return {name: run(solver, "paper") for name, solver in solvers.items()}


def test_all_solvers_agree_at_the_papers_tolerance(papers, newton):
    for name, (tip, _) in papers.items():
        assert np.abs(tip - newton["l2t2"]).max() < 1e-7, name


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


@pytest.mark.parametrize("update", UPDATES)
def test_full_memory_beats_the_chord_on_an_old_seed(update, papers):
    # One factor for 4000 steps, in fewer iterations than the 12 of a chord (numerics 1.5).
    stats = papers[update][1].stats
    assert stats.steps == 4000
    assert stats.factorizations == 1
    assert stats.iterations_per_step < (2.6 if update == "davidon" else 4.5)
    assert stats.recoveries == 0


def test_newton_needs_one_correction_when_steps_are_small(papers):
    assert papers["newton"][1].stats.iterations_per_step == pytest.approx(1.0, abs=0.01)


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


@pytest.mark.parametrize(
    ("options", "height", "bound"),
    [
        ({"nu": 0.0}, -1.2554, 1e-4),
        ({"nu": 0.0, "section_strain": "nodal"}, -1.20505, 2e-5),
        ({"nu": 0.3}, -1.25883, 2e-5),
    ],
    ids=str,
)
def test_nodal_strains_free_the_thick_pendulum_that_its_section_locks(options, height, bound):
    # nu = 0: -1.2554 m with 10 elements, -1.20505 with nodal section strains; thin: -1.20293.
    tip, _ = run(ancf.Newton(), 1e-6, "thick", t_end=0.5, save_every=1000, **options)
    assert tip[-1, 1] == pytest.approx(height, abs=bound)


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
