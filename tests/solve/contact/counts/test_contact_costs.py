"""The costs of an iteration count the forces of beams that touch, as they come and go."""

import ancfsparse as ancf
from ancfsparse.problems import pile
from ancfsparse.solve.stepping import implicit_setup


def test_costs_grow_with_the_pairs_that_touch(monkeypatch):
    costs = []

    def recorded(system, *args):
        costs.append(
            (sum(each.operations() for each in system.contributions), given(system, *args))
        )
        return costs[-1][1]

    given = implicit_setup.iteration_costs
    monkeypatch.setattr(implicit_setup, "iteration_costs", recorded)
    run = ancf.simulate(pile(10, 0.16).scene, 0.04, 2e-3, integrator=ancf.GeneralizedAlpha(0.5))
    operations, first = costs[0]
    assert operations == 0
    most, last = max(costs)
    assert most > run.system.operations("residual")
    assert last.iteration - first.iteration > 0.09 * most
    assert last.factor > first.factor
