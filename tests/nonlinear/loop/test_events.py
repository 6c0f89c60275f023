"""What a run tells of the steps it had to recover, and seeds where the tangent is indefinite."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.nonlinear import Attempt, Outcome
from ancfsparse.problems import pendulum
from ancfsparse.results import Event
from ancfsparse.results.hdf5_reader import load
from ancfsparse.seeds import SparseSeed
from ancfsparse.system import System
from tests.nonlinear.loop.handmade import Equations


@pytest.fixture(scope="module")
def climbed(tmp_path_factory):
    """Return a run whose steps need more corrections than allowed, and its file."""
    # Two corrections are not enough for a chord on an old seed, but they are for Newton.
    solver, path = ancf.ModifiedNewton(max_iterations=2), tmp_path_factory.mktemp("runs") / "run.h5"
    scene, _ = pendulum("l2t2")
    return ancf.simulate(scene, 0.5, 1e-3, solver=solver, tolerance="paper", output=path), path


def test_each_rung_says_why_it_was_climbed(climbed):
    run, _ = climbed
    events = run.stats.events
    assert {event.cause for event in events} == {"too many"}
    assert {event.rung for event in events} <= {"new seed", "damped Newton"}
    assert len({event.step for event in events}) == run.stats.recoveries > 0
    for event in events:
        assert event.time == pytest.approx(event.step * 1e-3)
        assert event.contraction > 0.0
    # Damped Newton comes after a new seed in the same step.
    seeds = {event.step for event in events if event.rung == "new seed"}
    assert {event.step for event in events if event.rung == "damped Newton"} <= seeds
    assert [event.step for event in events] == sorted(event.step for event in events)


def test_a_climbed_ladder_arrives_where_newton_does(climbed):
    run, _ = climbed
    scene, rod = pendulum("l2t2")
    path = ancf.simulate(scene, 0.5, 1e-3, solver=ancf.Newton(), tolerance="paper")
    end = run.system.scene.beams[0].end
    np.testing.assert_allclose(run.position(end), path.position(rod.end), rtol=0, atol=1e-6)


def test_a_run_without_trouble_has_none():
    scene, _ = pendulum("l2t2")
    assert ancf.simulate(scene, 0.1, 5e-4).stats.events == []


def test_events_survive_a_file(climbed):
    run, path = climbed
    again = load(path, run.system.scene).stats.events
    assert again == run.stats.events
    assert all(isinstance(event, Event) for event in again)


def test_the_first_thousand_are_kept():
    equations = Equations(lambda x: x**2 + 1.0, lambda x: np.diag(2.0 * x), [1.0])
    loop = equations.loop(equations.limited("broyden", 1), learns=True, max_iterations=3)
    for _ in range(600):
        assert loop.solve() != Outcome.CONVERGED
    events = loop.events
    assert len(events) == 1000
    assert [event[0] for event in events[:4]] == [1, 1, 1, 2]
    rungs = [Attempt.NEW_SEED, Attempt.DAMPED_NEWTON, Attempt.DESCENT, Attempt.NEW_SEED]
    assert [event[1] for event in events[:4]] == rungs
    assert events[-1][0] == 334


@pytest.mark.parametrize(
    ("residual", "start", "cause"),
    [
        (lambda x: np.arctan(x) * 3.0 + x, 0.3, Outcome.TOO_MANY),
        (lambda x: np.where(x > -0.5, x + 1e6 * (x < 0.2), np.nan), 0.3, Outcome.NOT_FINITE),
    ],
    ids=["too many", "not finite"],
)
def test_causes(residual, start, cause):
    equations = Equations(residual, lambda _: np.eye(1), [start])
    loop = equations.loop(equations.limited("broyden", 0), max_iterations=2, newton=False)
    loop.solve()
    assert loop.events[0][:3] == (1, Attempt.NEW_SEED, cause)


def test_a_failed_step_names_the_contraction():
    scene, _ = pendulum("l2t2")
    with pytest.raises(ancf.StepError, match=r"residual last changed by a factor of \d") as caught:
        ancf.simulate(scene, 1.0, 0.05, solver=ancf.ModifiedNewton(max_iterations=2),
                      tolerance="paper", max_energy_gain=np.inf)  # fmt: skip
    last = caught.value.trajectory.stats.events[-1]
    assert last.rung == "damped Newton with more iterations"
    assert last.step == caught.value.step


def saddle_like():
    """Roots of a gradient whose derivative at the start is indefinite, and a definite neighbour."""

    def residual(x):
        return np.array([x[0] ** 3 - x[0] - 0.2, 2.0 * x[1] - 1.0])

    def jacobian(x):
        return np.diag([3.0 * x[0] ** 2 - 1.0, 2.0])

    def material(x):
        return np.diag([3.0 * x[0] ** 2 + 1.0, 2.0])

    return residual, jacobian, [0.4, 0.0], 0, material


def test_an_indefinite_seed_is_replaced_by_its_material_part():
    equations = Equations(*saddle_like())
    loop = equations.loop(equations.limited("broyden", 5), learns=True)
    assert loop.solve() == Outcome.CONVERGED
    counts = loop.counts
    assert counts["indefinite"] == counts["material_seeds"] == 1
    assert counts["factorizations"] == 2
    assert equations.calls("material") == 1
    assert equations.x[0] == pytest.approx(1.0883, abs=1e-3)  # the stable root, uphill from 0.4
    # Without it the seed is kept as it is, and counted.
    equations = Equations(*saddle_like()[:4])
    loop = equations.loop(equations.limited("broyden", 5), learns=True)
    loop.solve()
    assert loop.counts["indefinite"] >= 1
    assert loop.counts["material_seeds"] == 0


def test_newtons_own_corrections_use_the_tangent():
    equations = Equations(*saddle_like())
    loop = equations.loop()
    assert loop.solve() == Outcome.CONVERGED
    assert loop.counts["indefinite"] >= 1
    assert equations.calls("material") == 0


def test_an_attempt_on_a_factor_with_wrong_signs_says_so():
    residual, jacobian, start, _, _ = saddle_like()
    equations = Equations(residual, jacobian, start)
    loop = equations.loop(equations.limited("broyden", 5), learns=True, max_iterations=1)
    loop.solve()
    assert loop.events[0][2] == Outcome.INDEFINITE


@pytest.mark.parametrize("force", [5.0, 50.0])
def test_the_material_part_is_definite_where_compression_is_not(force):
    # A straight free cable under N: indefinite from h = 2 sqrt(EI rho A) / N on (edge mode).
    scene = ancf.Scene((0.0, 0.0))
    section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)
    rod = scene.add_beam("l2t2", (0, 0), (2, 0), 40, section, material)
    system = System(scene)
    given = rod.stiffnesses()
    bending, mass = given["bending_stiffness"], given["mass_per_length"]
    limit = 2.0 * np.sqrt(bending * mass) / force
    # Green's strain e = (r'^2 - 1) / 2 and N = EA e r' at a uniform stretch.
    stretch = 1.0
    for _ in range(50):
        stretch = 1.0 - 2.0 * force / (given["axial_stiffness"] * stretch * (1.0 + stretch))
    q = system.q0 * stretch
    seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)

    def bad(h, part):
        if part == "material":
            return seed.factor(system.assembly.material(1.0, 0.25 * h**2, q))
        return seed.factor(system.assembly.matrix(1.0, 0.25 * h**2, q, np.zeros(0), np.zeros(0)))

    assert bad(0.9 * limit, "tangent") == 0
    assert bad(1.1 * limit, "tangent") != 0
    assert bad(10.0 * limit, "material") == 0
