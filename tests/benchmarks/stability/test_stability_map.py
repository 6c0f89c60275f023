"""The stability map as shipped: its claims, and its borders run again."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from benchmarks.commands import STUDIES, main
from benchmarks.stability.beam_map import (
    BEAMS,
    MAX_NEWTON_FRACTION,
    energy_balance,
    findings,
    largest_changes,
    select_calm_of_others,
    work_of,
    work_uncertainty,
)
from benchmarks.stability.cells import (
    FAILED,
    FINISHED,
    GAINED,
    OUTCOMES,
    RECOVERED,
    MapPoint,
    Run,
    recovered_fractions,
)
from benchmarks.stability.report import STUDY, integrator_chart, solver_chart
from benchmarks.stability.scenes import PUSH, SCENES, Case
from benchmarks.stability.stability_map import MAX_GAIN, Stability, read
from tests.paths import ROOT

SHIPPED = ROOT / "docs" / "data" / "stability.csv"

# Where steps are so long that elements change by this much of their length within one, which of two
# motions a step finds is open, and the watch may look beside a peak.
ROUGH = 0.05


@pytest.fixture(scope="module")
def shipped():
    return read(SHIPPED, BEAMS)


def borders_of(result, gain=0.5 * MAX_GAIN):
    """Pairs of neighbours in time step: the first completes, the second does not.

    Complete runs must be further from gaining energy than `gain` to be a border: one that is at the
    watch's limit is decided by rounding.
    """
    found = []
    for run in result.runs:
        if run.is_complete and run.gain < gain and run.map_point.dt in BEAMS.steps[:-1]:
            longer = BEAMS.steps[BEAMS.steps.index(run.map_point.dt) + 1]
            after = result.at.get(run.map_point._replace(dt=longer))
            if after is not None and not after.is_complete:
                found.append((run, after))
    return found


def some(runs, n):
    """Take n of them, evenly."""
    runs = list(runs)
    return [runs[k] for k in np.linspace(0, len(runs) - 1, min(n, len(runs))).astype(int)]


def test_the_table_is_the_whole_cut(shipped):
    points = BEAMS.map_points()
    assert [run.map_point for run in shipped.runs] == points
    n_cut = 2 * len(BEAMS.integrators) + len(BEAMS.for_all_solvers) * (len(BEAMS.solvers) - 2)
    assert len(points) == len(SCENES) * len(BEAMS.stiffnesses) * len(BEAMS.steps) * n_cut
    assert {run.outcome for run in shipped.runs} == set(OUTCOMES)
    assert SHIPPED.stat().st_size < 1e6


def test_what_newton_solves_the_others_solve(shipped):
    assert shipped.worse_than_newton(FAILED) == []
    assert shipped.worse_than_newton(GAINED) == []


def test_chance_is_what_ends_newton_either_way_too(shipped):
    chance = shipped.by_chance()
    assert 1 <= len(chance) <= 4
    assert all(shipped.at[run.map_point._replace(solver="Newton")].is_complete for run in chance)
    shortest = min(chance, key=lambda run: run.map_point.stiffness)
    assert BEAMS.ends_by_chance(shortest.map_point)
    completes, _ = borders_of(shipped)[0]
    assert not BEAMS.ends_by_chance(completes.map_point)


def test_no_run_ends_well_with_energy_from_nowhere(shipped):
    assert shipped.hidden_gains() == []


def test_calm_steps_hardly_need_damped_newton(shipped):
    others = select_calm_of_others(shipped)
    assert len(others) > 0.6 * len(list(shipped.with_newton()))
    assert max(run.newton for run in others) <= MAX_NEWTON_FRACTION


def test_the_shipped_borders_are_where_runs_end_today(shipped):
    borders = borders_of(shipped)
    assert len(borders) > 100
    runs = []
    for scene in SCENES:
        of_scene = [pair for pair in borders if pair[0].map_point.scene == scene]
        runs += [run for pair in some(of_scene, 8) for run in pair]
    other = [run for run in runs if BEAMS.run_at(run.map_point).is_complete != run.is_complete]
    assert len(other) <= 2, other  # of 80; 1 without AVX, else none
    assert all(BEAMS.ends_by_chance(run.map_point) for run in other), other


def test_newton_and_the_others_agree_today(shipped):
    # Independent of what is shipped: at the edge of what Newton solves, the others run once more.
    edges = [
        completes for completes, _ in borders_of(shipped) if completes.map_point.solver == "Newton"
    ]
    for completes in some(edges, 6):
        newton = BEAMS.run_at(completes.map_point)
        assert newton.is_complete
        for solver in BEAMS.solvers:
            map_point = completes.map_point._replace(solver=solver)
            if map_point in shipped.at:
                run = BEAMS.run_at(map_point)
                assert run.is_complete or BEAMS.ends_by_chance(map_point), run
                assert run.gain < MAX_GAIN, run


def test_work_of_a_force_is_force_times_way():
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 2, ancf.Rectangle(0.05, 0.05),
                         ancf.Material(1e8, 4000.0))  # fmt: skip

    def force(t):
        return 10.0 * t, 0.0

    scene.point_force(rod.end, force)
    case = Case(scene, rod, force)
    path = ancf.simulate(scene, 0.2, 1e-3, integrator=ancf.Newmark(0.0))
    # A free rod of 10 kg: a = t, so half its speed squared times its mass, but for vibrations.
    assert work_of(path, case)[-1] == pytest.approx(0.5 * 10.0 * (0.2**2 / 2) ** 2, rel=0.05)
    gain, loss = energy_balance(path, case)
    assert gain < 1e-3
    assert loss < 1e-3


def test_work_is_unsure_where_the_force_jumps_and_nowhere_else():
    case = SCENES["sudden force"](1e8)
    path = ancf.simulate(case.scene, 0.6, 1e-3)
    unsure, displacement = work_uncertainty(path, case), np.diff(path.position(case.rod.end)[:, 1])
    expected = np.zeros(len(path.t))
    for jump in case.jumps:
        after = int(np.argmax(path.t > jump))
        expected[after:] += 0.5 * PUSH * 0.8 * 9.81 * abs(displacement[after - 1])
    np.testing.assert_allclose(unsure, expected)
    assert energy_balance(path, case)[0] < MAX_GAIN
    assert not work_uncertainty(path, SCENES["compressed beam"](1e8)).any()


def test_turns_and_stretches_are_those_of_the_chords():
    case = SCENES["truss pendulum"](1e10)
    path = ancf.simulate(case.scene, 0.1, 1e-3)
    turn, stretch = largest_changes(path, case)
    assert turn == pytest.approx(1e-3 * 7.72 / 3.0443, rel=1e-3)
    assert stretch < 1e-6


def test_saved_steps_are_counted_by_rung():
    scene, _ = pendulum("l2t2")
    solver = ancf.ModifiedNewton(max_iterations=2)
    path = ancf.simulate(scene, 0.5, 1e-3, solver=solver, tolerance="paper")
    seed, newton = recovered_fractions(path)
    assert (seed + newton) * path.stats.steps == pytest.approx(path.stats.recoveries)
    assert ancf.simulate(scene, 0.1, 1e-3).stats.recoveries == 0


@pytest.mark.parametrize("dt", [2e-3, 4e-3, 5e-3, 1e-2, 2e-2, 5e-2])
def test_ten_seconds_where_fixed_steps_are_known_to_fail(dt):
    # Strong damping of second order comes through; the trapezoidal rule is stopped and says so.
    for integrator in (ancf.GeneralizedAlpha(0.5), ancf.HHT(0.3)):
        energy = ancf.simulate(pendulum("thin").scene, 10.0, dt, integrator=integrator).energy
        above = (energy.total - energy.total[0]) / energy.kinetic.max()
        assert above.max() < 1e-3
        assert -0.4 < above[-1] < 0.0
    for rho, longest in ((0.8, 5e-3), (0.9, 2e-3)):
        if dt <= longest:
            integrator = ancf.GeneralizedAlpha(rho)
            energy = ancf.simulate(pendulum("thin").scene, 10.0, dt, integrator=integrator).energy
            assert (energy.total - energy.total[0]).max() < 1e-3 * energy.kinetic.max()
    with pytest.raises(ancf.StepError, match=r"smaller dt|GeneralizedAlpha") as stop:
        ancf.simulate(pendulum("thin").scene, 10.0, dt, integrator=ancf.Newmark(0.0))
    assert stop.value.time < 10.0


def test_rows_survive_the_table():
    map_point = MapPoint("pendulum", 1e8, 1e-3, "Newmark(0)", "auto")
    measures = {"turn": 0.01, "stretch": 1e-3, "gain": 0.0, "loss": 1e-4}
    run = Run(map_point, RECOVERED, 2000, "", 2.25, 0.25, 0.125, measures)
    assert Run.of({name: str(value) for name, value in run.record().items()}, measures) == run


def test_a_small_map(run_study):
    words = ["--scene", "truss pendulum", "--stiffness", "1e6", "--stiffness", "2e11",
             "--step", "0.01", "--step", "0.02"]  # fmt: skip
    out, table, data, page = run_study("stability map", *words)
    assert f"{2 * 2 * 34} runs: " in out
    assert len(table) == 2 * 2 * 34
    assert {row["outcome"] for row in table} <= set(OUTCOMES)
    assert all(math.isfinite(float(row["gain"])) for row in table)
    soft = [row for row in table if row["stiffness"] == "1000000.0"]
    assert {row["outcome"] for row in soft} == {FINISHED}
    assert "damped Newton saved at most" in " ".join(data["findings"])
    assert re.search(r"^\| truss pendulum \| 0.0", page, re.M)


@pytest.fixture(scope="module")
def drawn(shipped):
    return {"stability": integrator_chart(shipped), "stability-solvers": solver_chart(shipped)}


@pytest.mark.slow
def test_charts_and_tables_come_from_the_table_too(run_study, drawn, tmp_path, monkeypatch):
    charts = {name: lambda _, figure=figure: figure for name, figure in drawn.items()}
    assert STUDY.charts.keys() == charts.keys()
    monkeypatch.setitem(STUDIES, "stability map", replace(STUDY, charts=charts))
    out = run_study("stability map", "--from", str(SHIPPED)).out
    assert re.search(r"^  bfgs, 10 pairs +GeneralizedAlpha\(0\.8\) ", out, re.M)
    assert "of Newton's own calm runs, at most 11 %." in out
    assert (tmp_path / "stability.csv").read_bytes() == SHIPPED.read_bytes()


def test_the_charts_can_be_read(drawn, readable):
    for figure in drawn.values():
        readable(figure)


def test_a_table_that_is_none_is_refused(tmp_path, capsys):
    rows = SHIPPED.read_text(encoding="utf-8").splitlines()
    table = tmp_path / "table.csv"
    cases = {
        "leave out": (rows[0], ["--step", "0.01"]),
        "holds no run": (rows[0], []),
        "column or number is missing": (rows[0].replace("outcome", "end") + "\n" + rows[1], []),
        "No such file": (None, []),
    }
    for message, (text, words) in cases.items():
        table.unlink(missing_ok=True)
        if text is not None:
            table.write_text(text + "\n", encoding="utf-8")
        with pytest.raises(SystemExit) as left:
            main(["stability", "map", "--from", str(table), *words, "--output", str(tmp_path)])
        assert left.value.code == 2
        assert message in capsys.readouterr().err


def made_up(solver, outcome, dt=0.01):
    map_point = MapPoint("pendulum", 1e8, dt, "Newmark(0)", solver)
    measures = {"turn": 0.0, "stretch": 0.0, "gain": 0.0, "loss": 0.5}
    return Run(map_point, outcome, 1, "", 1.0, 0.0, 0.0, measures)


def test_the_solver_chart_shows_the_worst_and_frames_what_differs():
    runs = [made_up("Newton", FINISHED), made_up("Newton", FAILED, 0.02)]
    for solver in BEAMS.solvers:
        if solver != "Newton":
            bad = solver in ("auto", "modified Newton")
            runs.append(made_up(solver, GAINED if bad else FINISHED))
            runs.append(made_up(solver, FAILED if bad else RECOVERED, 0.02))
    with_both = [replace(run, map_point=run.map_point._replace(integrator="GeneralizedAlpha(0.8)"))
                 for run in runs]  # fmt: skip
    result = Stability(runs + with_both, {}, BEAMS)
    assert findings(result)[0].startswith(
        "Other solvers than Newton at the same 40 points: 0 failed and 4 were stopped for energy "
        "where Newton finished, 16 finished where Newton did not."
    )
    newton, conservative, full, *_ = solver_chart(result).axes
    worst = [[OUTCOMES[int(k)] for k in ax.images[0].get_array().ravel()]
             for ax in (newton, conservative, full)]  # fmt: skip
    assert worst == [[FINISHED, FAILED], [GAINED, FAILED], [FINISHED, RECOVERED]]
    assert [text.get_text() for text in conservative.texts] == ["2", "2", "67 %"]
    frames = [[(p.get_x() + 0.5, p.get_linestyle()) for p in ax.patches]
              for ax in (newton, conservative, full)]  # fmt: skip
    assert frames == [[], [(0.0, "-"), (1.0, ":")], [(1.0, ":")]]
    assert list(newton.lines) == []  # losses belong to integrators, and are marked in their chart


def test_unknown_scenes_and_bad_steps_are_refused():
    for words, name in ((["--scene", "pendulums"], "scene"), (["--step", "-1"], "step")):
        with pytest.raises(SystemExit) as left:
            main(["stability", "map", *words])
        assert left.value.code != 0, name
