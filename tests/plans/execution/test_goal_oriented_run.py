"""`simulate` with a quantity and its error equals `plan` and `Plan.run`, and repeats no run."""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.execution import run_plan
from ancfsparse.plans.trial_runs import solution_methods, trial_runs
from ancfsparse.plans.trial_runs.solution_methods import ModalSum, Statics
from ancfsparse.scene.bodies.body import Point

ROUND, SOFT = ancf.Circle(0.02), ancf.Material(1e8, 1000)


def make_scene(dim):
    """Return a scene under gravity along its last axis, and points of its plane of motion."""
    none = (0.0,) * (dim - 2)
    return ancf.Scene((0.0, *none, -9.81)), lambda x, y=0.0: (x, *none, y)


def pulled(dim=2):
    """A sagging cable, one end of which is pulled slowly: equilibria."""
    scene, at = make_scene(dim)
    rope = scene.add_beam("thin", at(0), at(1), "auto", ancf.Circle(0.005), SOFT, length=1.1)
    scene.pin(rope.start)
    scene.drive(rope.end, ancf.Ramp(at(0.08), 20.0, smooth=True) + np.array(at(1.0)))
    return scene, rope.at(0.55), 20.0, "20 %"


def plucked(dim=2):
    """A cantilever that a light load bends for many periods: modes."""
    scene, at = make_scene(dim)
    scene = ancf.Scene(at(0))
    rod = scene.add_beam("thin", at(0), at(1), "auto", ROUND, SOFT)
    scene.clamp(rod.start)
    scene.point_force(rod.end, at(0, -2e-5))
    return scene, rod.end, 60.0, "1 %"


def falling(dim=2):
    """A slightly taut line that begins to fall: explicit steps."""
    scene, at = make_scene(dim)
    line = scene.add_beam("thin", at(0), at(1), "auto", ROUND, SOFT, tension=400.0)
    scene.pin(line.start)
    scene.pin(line.end)
    return scene, line.at(0.5), 0.02, "1 %"


def swinging(dim=2):
    """A pendulum: implicit steps."""
    scene, at = make_scene(dim)
    rod = scene.add_beam("thin", at(0), at(1), "auto", ROUND, SOFT)
    scene.pin(rod.start)
    return scene, rod.end, 0.4, "1 %"


def swinging_exactly(dim=2):
    """The same to a tenth of a micrometre: a run that is none of the trial runs."""
    scene, point, _, _ = swinging(dim)
    return scene, point, 1.0, 1e-7


# Some of these errors are not met, as with a step that the user gives.
pytestmark = pytest.mark.filterwarnings("ignore::ancfsparse.ErrorNotMetWarning")

WAYS = {
    pulled: Statics,
    plucked: ModalSum,
    falling: ancf.CentralDifference,
    swinging: ancf.GeneralizedAlpha,
    swinging_exactly: ancf.GeneralizedAlpha,
}
OPTIONS = {
    "none": {},
    "defaults": {"threads": 1, "progress": False, "save_nodes": None, "output": None},
    "save_every": {"save_every": 3},
    "a single state": {"save_every": 2**64 - 1},
    "save_nodes": {"save_nodes": ["end"]},
    "output": {"output": "run.h5"},
    "some in a file": {"save_nodes": ["end"], "output": "run.h5", "save_every": 2},
    "threads": {"threads": 2},
    "progress": {"progress": True},
    "solver": {"solver": ancf.Newton()},
    "factorization": {"factorization": "complete"},
    "max_energy_gain": {"max_energy_gain": 0.02},
    "max_halvings": {"max_halvings": 2},
    "start": {"start": "equilibrium"},
    "integrator": {"integrator": ancf.Newmark(0.1)},
    "dt": {"dt": 1 / 400},
}
OF_EQUATIONS = {"solver", "factorization", "max_energy_gain", "max_halvings"}
OF_PLANS = {"start", "integrator", "dt"}


class Planned(NamedTuple):
    """A scene, the point asked for, its plan, the runs that took, and the run in every step."""

    scene: ancf.Scene
    point: Point
    plan: ancf.Plan
    n_runs: int
    whole: ancf.Trajectory


@pytest.fixture(scope="module")
def counted():
    """List motions and paths of equilibria as they are made."""
    made = []

    def count(patch, module, name):
        original = getattr(module, name)

        def run(*args, **options):
            made.append(name)
            return original(*args, **options)

        patch.setattr(module, name, run)

    with pytest.MonkeyPatch.context() as patch:
        count(patch, trial_runs, "run_request")
        count(patch, run_plan, "simulate")
        count(patch, solution_methods, "quasi_static")
        count(patch, solution_methods, "modal_response")
        yield made


@pytest.fixture
def runs(counted):
    """List the runs of one test."""
    counted.clear()
    return counted


@pytest.fixture(scope="module")
def planned(counted):
    """Return a function that plans a scene once for all tests."""

    @cache
    def make(build, dim, of_plan, of_equations):
        """Plan a scene with options given as items."""
        scene, point, t_end, error = build(dim)
        counted.clear()
        plan = ancf.plan(scene, t_end, ancf.position(point), error, **dict(of_plan))
        number = len(counted)
        whole = plan.run(save_every=1, **dict(of_equations))
        return Planned(scene, point, plan, number, whole)

    return make


@pytest.mark.parametrize(
    ("build", "name"),
    [
        (build, name)
        for build in WAYS
        for name in OPTIONS
        if (build is pulled and name != "dt")  # others rest; with long steps it leaves its range
        or (
            build is not pulled
            and name != "start"
            and (build in (falling, swinging) or name not in OF_EQUATIONS | OF_PLANS)
        )
    ],
)
def test_a_run_to_an_error_is_that_of_its_plan_and_made_once(build, name, runs, planned, tmp_path):
    dim = 3 if name in ("none", "output", "save_nodes") else 2
    *_, t_end, error = build(dim)
    given = dict(OPTIONS[name])
    if "dt" in given:
        given["dt"] *= t_end
    of_plan = {key: value for key, value in given.items() if key in OF_PLANS}
    of_equations = {key: value for key, value in given.items() if key in OF_EQUATIONS}
    if of_equations:
        of_plan["integrator"] = ancf.GeneralizedAlpha(0.9)
    scene, point, plan, alone, whole = planned(
        build, dim, tuple(of_plan.items()), tuple(of_equations.items())
    )
    if given.get("save_nodes"):
        given["save_nodes"] = [point]
    quantity, output = ancf.position(point), given.get("output")

    def options(of):
        return {**given, "output": tmp_path / f"{of}.h5"} if output else given

    runs.clear()
    run = ancf.simulate(scene, t_end, quantity=quantity, error=error, **options("one"))
    together = len(runs)
    same = plan.run(**{k: v for k, v in options("two").items() if k not in OF_PLANS})
    assert run.plan.choice == plan.choice
    if not of_plan:
        assert isinstance(plan.integrator, WAYS[build])
    is_made = plan.result is not None and not of_equations
    assert build is not swinging_exactly or plan.result is None
    assert together == alone + (not is_made)

    def columns(run, name):
        table = getattr(run, name)
        return np.asarray(table.values if hasattr(table, "values") else table)

    for table in ("t", "q", "v", "a", "lam"):
        assert np.array_equal(columns(run, table), columns(same, table))
    assert np.array_equal(run.position(point), same.position(point))
    assert run.finished == run.plan.is_met
    # The saved states are part of the whole run.
    every = min(given.get("save_every", plan.save_every), len(whole.t))
    rows = np.append(np.arange(0, len(whole.t) - 1, every), len(whole.t) - 1)
    assert np.array_equal(run.t, whole.t[rows])
    assert np.array_equal(run.position(point), whole.position(point)[rows])
    if output:
        again = ancf.load(tmp_path / "one.h5")
        assert np.array_equal(again.t, run.t)
        assert np.array_equal(columns(again, "q"), columns(run, "q"))
    if given.get("save_nodes"):
        with pytest.raises(ancf.InputError, match="save_nodes"):
            run.position(scene.beams[0].at(0.2))


@pytest.mark.parametrize("build", [pulled, swinging])
def test_arguments_are_checked_before_the_plan(build, runs):
    scene, point, t_end, error = build()
    for wrong in (
        {"save_every": 0},
        {"save_nodes": point},
        {"output": 3},
        {"progress": "no"},
        {"threads": 0},
        {"solver": "fast"},
        {"max_halvings": -1},
        {"max_energy_gain": -1.0},
    ):
        with pytest.raises(ancf.InputError, match=next(iter(wrong))):
            ancf.simulate(scene, t_end, quantity=ancf.position(point), error=error, **wrong)
    assert not runs
