"""Steps so long that only Newton's own corrections solve them: the rungs that save the others."""

import numpy as np
import pytest
from handmade import Equations

import ancfsparse as ancf
from ancfsparse.nonlinear import Outcome
from ancfsparse.studies.stability_scenes import SCENES

NEW_SEED = 1


def test_an_attempt_with_a_new_seed_renews_it_where_waiting_costs_more():
    # A hardening spring far out: at rest it is 150 times softer than the seed at the start.
    equations = Equations(
        lambda x: 50.0 * x**3 + x - 0.1, lambda x: np.diag(150.0 * x**2 + 1.0), [1.0]
    )
    loop = equations.loop(
        equations.limited("broyden", 0), learns=False, max_iterations=15, cost_seed=1.0
    )
    assert loop.solve() == Outcome.CONVERGED
    root = equations.x[0]
    assert 50.0 * root**3 + root == pytest.approx(0.1, rel=1e-9)
    assert [event[1] for event in loop.events] == [NEW_SEED]
    assert loop.counts["recoveries_reseed"] == 1
    assert loop.counts["reseeds_inside"] > 1


@pytest.mark.parametrize(
    ("scene", "stiffness", "dt", "solver"),
    [
        ("rod at the tip", 1e8, 0.02, "auto"),
        ("rod at the tip", 1e7, 0.01, ancf.QuasiNewton("bfgs", 10)),
        ("compressed beam", 1e10, 0.02, ancf.QuasiNewton("dfp")),
    ],
    ids=str,
)
def test_what_newton_solves_the_ladder_solves(scene, stiffness, dt, solver):
    # Damped Newton fails in some of these steps, and undamped does not.
    n = round(2.0 / dt)
    runs = []
    for method in (ancf.Newton(), solver):
        case = SCENES[scene](stiffness)
        runs.append(ancf.simulate(case.scene, n * dt, dt, solver=method,
                                  integrator=ancf.GeneralizedAlpha(0.8)))  # fmt: skip
    assert runs[1].stats.steps == runs[0].stats.steps == n
    assert runs[1].stats.recoveries > 0


@pytest.mark.parametrize(
    "solver",
    [ancf.QuasiNewton("broyden"), ancf.QuasiNewton("bfgs"), ancf.ModifiedNewton()],
    ids=str,
)
def test_a_stiff_bar_that_turns_gains_no_energy_by_false_belief(solver):
    # Its tangent is stiff in both coordinates of a node and soft across the bar: a residual that
    # would turn the bar is small over the diagonal.
    ends = []
    for method in (ancf.Newton(), solver):
        case = SCENES["truss pendulum"](2e11)
        run = ancf.simulate(
            case.scene, 2.0, 0.02, solver=method, integrator=ancf.GeneralizedAlpha(0.8)
        )
        energy = run.energy
        assert (energy.total - energy.total[0]).max() < 1e-6 * energy.kinetic.max()
        ends.append(run.position(case.rod.end)[-1])
    assert np.linalg.norm(ends[1] - ends[0]) < 1e-2
