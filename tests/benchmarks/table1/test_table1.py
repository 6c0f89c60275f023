"""Table 1 on a short run: shapes, files and the sentences on them."""

import math

import numpy as np
import pytest

from ancfsparse.errors import InputError, StepError
from benchmarks.common import paper
from benchmarks.table1 import cells, figures, report
from benchmarks.table1.report import findings
from benchmarks.table1.table import table1

ROWS = ("L2T2", "Thin")


@pytest.fixture(scope="module")
def table():
    return table1(ROWS, t_end=0.05, cap=20.0, runs=2)


def test_every_cell_has_a_time_and_an_error(table):
    assert list(table.cells) == [(row, column) for row in ROWS for column in cells.COLUMNS]
    for cell in table.cells.values():
        assert cell.finished, cell
        assert cell.seconds > 0.0
        assert 0.0 < cell.tip_error < 1e-4
        assert cell.tip.shape == table.references[cell.row].shape
    assert len(table.t) == len(table.references["L2T2"])
    assert table.t[-1] == pytest.approx(0.05)


def test_methods_of_ours_agree_far_below_their_error(table):
    for row in ROWS:
        davidon = table.cells[row, "Davidon"].tip
        for column in cells.METHODS:
            np.testing.assert_allclose(table.cells[row, column].tip, davidon, rtol=0, atol=1e-8)


def test_matched_runs_are_at_least_as_good(table):
    assert {column for _, column in table.matches} == set(paper.ODE_FUNCTIONS)
    for (row, column), match in table.matches.items():
        if match.found:
            assert match.tip_error <= table.cells[row, column].tip_error
            assert match.ratio == pytest.approx(table.cells[row, column].seconds / match.seconds)


def test_files_hold_the_table(table, run_result):
    out, rows, data, page = run_result("table1", table)
    assert len(rows) == 2 * len(cells.COLUMNS)
    assert list(rows[0]) == [
        "element", "method", "stands_for", "seconds", "paper_seconds", "speed_up",
        "iterations_per_step", "evaluations", "tip_error_m", "runs", "set_up_seconds", "note",
    ]  # fmt: skip
    broyden = next(row for row in rows if (row["element"], row["method"]) == ("Thin", "Broyden"))
    assert float(broyden["paper_seconds"]) == 7.22
    assert float(broyden["speed_up"]) == pytest.approx(7.22 / float(broyden["seconds"]))
    assert len(data["cells"]) == len(rows)
    assert data["findings"] == findings(table)
    assert data["settings"]["instruction_set"].startswith("x86_64")
    for words in (*ROWS, *cells.COLUMNS, "ode23t", "10.10"):
        assert words in out
    for words in ("| Radau, for `ode23t` |", "(1.69)", "set-up before the first step"):
        assert words in page
    begin, end = "<!-- table1-findings:begin -->\n", "\n<!-- table1-findings:end -->"
    assert begin + "\n".join(f"- {each}" for each in findings(table)) + end in page


def test_the_march_of_a_cell_leaves_its_set_up_out(table, monkeypatch):
    real = cells.simulate_paper

    def timed(*arguments):
        run = real(*arguments)
        run.stats.march_seconds, run.stats.seconds["set-up"] = 0.25, 7.0
        return run

    monkeypatch.setattr(cells, "simulate_paper", timed)
    reference = cells.reference("Thin", 0.01, 5e-4)
    cell = cells.Bench("Thin", 0.01, 5e-4, reference, 20.0, 1).run("Davidon")
    assert (cell.seconds, cell.set_up_seconds) == (0.25, 7.0)
    assert math.isnan(table.cells["Thin", "RK23"].set_up_seconds)


def test_figures_are_drawn_with_units(table):

    among, against, off = figures.figure2(table).axes
    assert off.get_xlabel() == "time [s]"
    assert all(ax.get_ylabel().endswith("[m]") for ax in (among, against, off))
    davidon, bfgs = (table.cells["Thin", each].tip[:, 1] for each in ("Davidon", "BFGS"))
    labels = [text.get_text() for text in among.get_legend().get_texts()]
    assert f"Davidon – BFGS: {np.abs(davidon - bfgs).max():.1e} m" in labels
    assert "ode23t" in against.get_title()


def test_cell_out_of_time_says_so_and_the_rest_goes_on():
    table = table1(("L2T2",), t_end=0.05, cap=0.001, runs=1)
    cell = table.cells["L2T2", "Radau"]
    assert cell.note == "> 0.001 s"
    assert not cell.finished
    assert math.isnan(cell.seconds)
    assert cell.record()["seconds"] is None
    assert "> 0.001 s" in report.STUDY.text(table)
    assert table.cells["L2T2", "Davidon"].finished
    assert any("no SciPy method finished" in each for each in findings(table))
    figures.figure2(table)


@pytest.mark.parametrize(
    ("how", "sentence"),
    [
        ({"dt": 3e-4}, "does not divide"),
        ({"dt": -1.0}, "dt must be positive"),
        ({"cap": 0.0}, "cap must be positive"),
        ({"runs": 0}, "at least 1"),
        ({"rows": ("Thinn",)}, "did you mean 'Thin'"),
    ],
)
def test_bad_settings_are_refused_before_anything_runs(how, sentence):
    with pytest.raises(InputError, match=sentence):
        table1(**{"rows": ("L2T2",), "t_end": 0.05, **how})


def test_cell_that_fails_is_named_and_the_rest_goes_on(monkeypatch):
    def march(problem, column, *rest):
        if column == "Davidon" and rest[-1] > 1:
            raise StepError("no convergence", 0.01, 20, 5e-4, 1.0, "rod, node 1, r_1")
        return real(problem, column, *rest)

    real = cells.simulate_paper
    monkeypatch.setattr(cells, "simulate_paper", march)
    table = table1(("Thin",), t_end=0.4, dt=5e-4, cap=0.001, runs=1)
    assert table.cells["Thin", "Davidon"].note == "failed at 0.01 s"
    assert table.cells["Thin", "BFGS"].finished
    assert not table.matches
    assert "Thin, Davidon: no result, failed at 0.01 s." in findings(table)
    assert "failed at 0.01 s" in report.STUDY.region("table1", table)
    figures.figure2(table)


def test_output_times_are_whole_steps_that_reach_the_end():
    assert cells.output_times(2.0, 5e-4)[0] == 10
    for t_end, dt in ((2.0, 5e-4), (0.05, 5e-4), (0.035, 5e-3), (1.001, 1e-3)):
        every, t = cells.output_times(t_end, dt)
        assert t[-1] == pytest.approx(t_end)
        assert t[1] == pytest.approx(every * dt)


def test_numbers_of_the_paper_are_those_of_its_table():
    printed = """
        L2T2	5.3	9.4	10.1	3.69	1.69	3.06	2.96
        Thin	7.1	11.9	11.5	7.22	2.96	6.32	6.14
        Thick	311.0	221.3	375.6	19.20	10.49	20.24	27.61
    """
    columns = "RK23 LSODA Radau Broyden Davidon DFP BFGS".split()
    assert tuple(paper.ODE_FUNCTIONS.values()) == ("ode23", "ode113", "ode23t")
    expected = {}
    for line in printed.strip().splitlines():
        row, *numbers = line.split()
        expected[row] = dict(zip(columns, map(float, numbers), strict=True))
    assert expected == paper.SECONDS


def test_shapes_of_figure_1_end_at_the_tip(table):
    run, rod = table.motion, table.problem.rod
    drawn = figures.figure1(table).axes[0].lines[: figures.SNAPSHOTS]
    rows = np.linspace(0, len(run.t) - 1, figures.SNAPSHOTS).round().astype(int)
    tips = run.position(rod.end)[rows, :2]
    np.testing.assert_allclose([line.get_xydata()[-1] for line in drawn], tips, rtol=0, atol=1e-12)
