"""The map of runs with contact as shipped: its claims, its measures, and some runs once more."""

from types import SimpleNamespace

import numpy as np
import pytest

import ancfsparse as ancf
from benchmarks.commands import main
from benchmarks.stability.cells import FAILED, FINISHED, Run
from benchmarks.stability.contact_map import (
    CONTACTS,
    depth_limit,
    energy_changes,
    findings,
    largest_depth,
    select_unsolved,
)
from benchmarks.stability.contact_scenes import (
    FALL_HEIGHT,
    GRAVITY,
    SCENES,
    add_contact,
    compute_reference_stiffness,
)
from benchmarks.stability.report import CONTACT_STUDY, integrator_chart, solver_chart
from benchmarks.stability.stability_map import Stability, read
from tests.paths import ROOT

SHIPPED = ROOT / "docs" / "data" / "stability-contact.csv"


@pytest.fixture(scope="module")
def shipped():
    return read(SHIPPED, CONTACTS)


def test_the_table_is_the_full_cut(shipped):
    assert [run.map_point for run in shipped.runs] == CONTACTS.map_points()
    assert len(shipped.runs) == len(SCENES) * 5 * 6 * (2 * 4 + 2 * 4)


def test_no_run_ends_with_a_hidden_gain_or_inside_an_obstacle(shipped):
    assert shipped.hidden_gains() == []
    complete = [run for run in shipped.runs if run.is_complete]
    assert not [run for run in complete if run.measures["depth"] > depth_limit(run)]


def test_short_runs_end_as_shipped(shipped):
    points = CONTACTS.map_points(steps=[5e-3], stiffnesses=[1.0], solvers=["Newton"])
    other = [point for point in points if CONTACTS.finishes(point) != shipped.at[point].is_complete]
    assert len(other) <= 2, other  # of 52: near the limit rounding decides


def test_steps_that_no_solver_solves_end_where_they_are_halved(shipped):
    unsolved = select_unsolved(shipped)
    assert 10 < len(unsolved) < 60
    for point in unsolved:
        case, t_end = SCENES[point.scene](point.stiffness), CONTACTS.n_steps(point.dt) * point.dt
        integrator = CONTACTS.integrators[point.integrator]
        path = ancf.simulate(case.scene, t_end, point.dt, integrator=integrator)
        assert path.t[-1] == pytest.approx(t_end)


def test_the_reference_stiffness_is_that_for_a_tenth_of_the_radius():
    # An impact at sqrt(2 g h) is to sink in by a tenth of the radius of 5 mm.
    mass = 2e3 * np.pi * 5e-3**2
    expected = mass * 2.0 * GRAVITY * FALL_HEIGHT / 5e-4**2
    assert compute_reference_stiffness("level fall") == pytest.approx(expected, rel=1e-6)
    case = SCENES["level fall, no friction"](10.0)
    assert case.contact.stiffness == pytest.approx(10.0 * expected, rel=1e-6)


def test_an_impact_sinks_in_by_a_tenth_of_the_radius():
    case = SCENES["level fall, no friction"](1.0)
    path = ancf.simulate(case.scene, 0.05, 2e-4, integrator=ancf.EnergyMomentum())
    # The weight adds to it: e = w / k + sqrt((w / k)^2 + v^2 mu / k).
    stiffness, mass = case.contact.stiffness, 2e3 * np.pi * 5e-3**2
    rest = mass * GRAVITY / stiffness
    deepest = rest + np.sqrt(rest**2 + mass * 2.0 * GRAVITY * FALL_HEIGHT / stiffness)
    assert largest_depth(path, case) == pytest.approx(deepest / 5e-3, rel=0.01)
    gain, loss = energy_changes(path)
    assert gain < 1e-8
    assert loss < 1e-8


@pytest.mark.parametrize("name", SCENES)
def test_with_default_arguments_every_run_ends_with_penetrations_of_at_most_a_hundredth(name):
    for integrator in CONTACTS.integrators.values():
        for dt in (1e-3, 5e-3):
            case = add_contact(*name.split(", "), None)
            t_end = round(CONTACTS.t_end / dt) * dt
            path = ancf.simulate(case.scene, t_end, dt, integrator=integrator)
            assert largest_depth(path, case) < 0.01


def test_a_point_that_passes_through_within_a_step_is_deep():
    # Two states on either side of the ball: none of them is inside, but the way between them is.
    case = SCENES["net on a ball, no friction"](1.0)
    path = ancf.simulate(case.scene, 1e-4, 1e-4)
    above = np.asarray(path.q)[0]
    shift = -2.0 * path.system.uniform(2)
    same, passed = (
        SimpleNamespace(q=np.array([above, other]), system=path.system)
        for other in (above, above + shift)
    )
    assert largest_depth(same, case) < 0.0
    assert largest_depth(passed, case) > 10.0


def test_energy_that_friction_hides_is_a_gain():
    # A body that loses nothing, though friction has taken half of its kinetic energy.
    none = np.zeros(2)
    energy = SimpleNamespace(
        total=np.ones(2), kinetic=np.ones(2), elastic=none, potential=none, contact=none,
        work=none, friction=np.array([0.0, 0.5]),
    )  # fmt: skip
    assert energy_changes(SimpleNamespace(energy=energy)) == (0.5, 0.0)


def made_up(solver, outcome, depth=0.1, gain=0.0):
    point = CONTACTS.map_points(
        ["level fall, no friction"], [1.0], [1e-3], ["EnergyMomentum"], [solver]
    )[0]
    return Run(point, outcome, 50, "", 2.0, 0.0, 0.0, {"depth": depth, "gain": gain, "loss": 0.0})


def test_findings_name_failures_gains_and_bodies_that_sank_in():
    runs = [
        made_up("Newton", FINISHED),
        made_up("auto", FAILED),
        made_up("bfgs, full", FINISHED, depth=0.5),
        made_up("bfgs, 10 pairs", FINISHED, gain=0.02),
    ]
    text = " ".join(findings(Stability(runs, {}, CONTACTS)))
    where = "level fall, no friction, stiffness 1, dt = 0.001 s, EnergyMomentum"
    assert f"Only Newton finishes: {where}, auto: failed at 0.05 s" in text
    assert f"Sank in: {where}, bfgs, full: 0.5 radii." in text
    assert f"Gained between two checks of the energy: {where}, bfgs, 10 pairs: 2 %." in text
    data = CONTACT_STUDY.as_record(Stability(runs, {}, CONTACTS))
    assert data["only_newton_finishes"] == [
        "python -m benchmarks stability contact --scene 'level fall, no friction' --stiffness 1 "
        "--step 0.001 --integrator 'EnergyMomentum' --solver Newton --solver 'auto'"
    ]


def test_a_small_map(run_study):
    words = ["--scene", "level fall, no friction", "--stiffness", "1", "--step", "0.005"]
    words += ["--integrator", "EnergyMomentum", "--solver", "Newton", "--solver", "auto"]
    out, table, _, page = run_study("stability contact", *words)
    assert "2 runs: " in out
    assert [row["solver"] for row in table] == ["Newton", "auto"]
    assert "| level fall, no friction | 0.005 s, 100 % |" in page


def test_the_charts_can_be_read(shipped, readable):
    readable(integrator_chart(shipped))
    readable(solver_chart(shipped))


def test_pairs_outside_the_cut_are_refused(capsys):
    for words, message in (
        (["--integrator", "Newmark(0)", "--solver", "bfgs, full"], "the map has no run of"),
        (["--solver", "gauss"], "solver"),
    ):
        with pytest.raises(SystemExit) as left:
            main(["stability", "contact", *words])
        assert left.value.code == 2
        assert message in capsys.readouterr().err
