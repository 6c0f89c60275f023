"""The study of memory lengths: its model of cost, its files, and what it dares to say."""

import pytest

from ancfsparse.nonlinear import ModifiedNewton, QuasiNewton
from ancfsparse.nonlinear.iteration import Costs
from ancfsparse.nonlinear.methods import UPDATES
from benchmarks.scaling.secant_pairs import LENGTHS, PairRun, SecantPairs, chart, model_cost

COSTS = Costs(residual=60.0, solve=40.0, factor=1000.0)


def test_model_counts_iterations_seeds_and_terms():
    chord = model_cost(COSTS, 10, 10, 30, 2, ModifiedNewton())
    assert chord == pytest.approx((30 * 100 + 2 * 1000) / 10)
    # Three corrections in a step see 0, 1 and 2 pairs: 1 on average, 2 operations per unknown.
    own = model_cost(COSTS, 10, 10, 30, 2, QuasiNewton("broyden", memory=10))
    assert own - chord == pytest.approx(30 * 2 * 10 * 1.0 / 10)
    # A carried memory of 5 holds 1, 2, ... 5 pairs in turn, and BFGS has two terms for each.
    carried = model_cost(COSTS, 10, 10, 30, 2, QuasiNewton("bfgs", memory=5, carry=True))
    assert carried - chord == pytest.approx(30 * 2 * 10 * 3.0 * 2 / 10)


def test_verdict_follows_the_counts():
    def run(update, pairs, carry, cost, iterations):
        return PairRun("chain", update, pairs, carry, iterations, 1, 0, 0, cost, [cost])

    chord = run("chord", 0, False, 10.0, 3.0)
    own, carried = run("broyden", 5, False, 8.0, 2.5), run("bfgs", 10, True, 12.0, 2.0)
    (finding,) = SecantPairs([chord, own, carried], {}).findings()
    assert "this step's pairs pay: 0.80 of the cost" in finding
    assert "carried pairs do not pay: 1.50 of the cost" in finding
    assert "fall from 3.00 (chord) and 2.50 to 2.00 per step" in finding


def test_study_on_tiny_sizes(run_study):
    words = ["--chain", "12", "--net", "3", "--steps", "3", "--rounds", "1"]
    out, table, data, page = run_study("scaling secant-pairs", *words)
    assert "net 3 x 3, rough: this step's pairs" in out
    assert len(table) == 4 * (1 + len(UPDATES) * 2 * len(LENGTHS))
    assert all(float(row["model_cost"]) > 0 for row in table)
    assert len(data["findings"]) == 4
    assert page.count("| chord |") == 4
    assert page.count(" carried |") == 4
    assert "- net 3 x 3, rough: this step's pairs" in page


def test_the_chart_can_be_read(readable):
    runs = []
    for scene in ("chain of 1000, smooth", "chain of 1000, rough", "net 20 x 20, smooth",
                  "net 20 x 20, rough"):  # fmt: skip
        runs.append(PairRun(scene, "chord", 0, False, 3.0, 5, 0, 0, 10.0, [1.0]))
        for update in UPDATES:
            for carry in (False, True):
                for pairs in LENGTHS:
                    runs.append(PairRun(scene, update, pairs, carry, 2.5, pairs, 0, 0, 9.0, [0.5]))
    figure = chart(SecantPairs(runs, {}))
    readable(figure)
    seeds = figure.axes[4].lines[0]
    assert seeds.get_ydata()[0] == 5
    assert list(seeds.get_ydata()[1:]) == list(LENGTHS)
