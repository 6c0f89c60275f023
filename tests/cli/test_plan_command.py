"""The command ``ancfsparse plan``."""

import pytest
from typer.testing import CliRunner

from ancfsparse import cli
from ancfsparse.cli.app import app
from ancfsparse.cli.planned import compare_with_paper, plan_scene
from ancfsparse.errors import (
    AssemblyError,
    EquilibriumError,
    InputError,
    LoadError,
    ModesError,
    OutputError,
    PlanError,
)
from tests.cli.command import run as run_command

run = CliRunner().invoke


def test_a_sagging_line_is_planned_run_and_verified():
    result = run(app, ["plan", "line"])
    assert result.exit_code == 0, result.output
    assert "Plan for the equilibrium" in result.output
    assert "measured" in result.output
    assert "measured" not in run(app, ["plan", "line", "--no-run"]).output


def test_a_short_twisted_beam_is_no_cable():
    plan = plan_scene("twisted", None)
    (rung,) = plan.model.elements.values()
    assert rung.name == "thick"
    assert plan.is_met


def test_bad_input_gets_a_sentence():
    with pytest.raises(InputError, match="unknown scene 'nett': did you mean 'net'"):
        plan_scene("nett", None)
    with pytest.raises(InputError, match="--error needs a number"):
        plan_scene("line", "much")


@pytest.mark.parametrize(
    "failure",
    [
        PlanError("position of beam 0 at s = 1 m", 1e-3, 2e-3, "m", 4, 0.5),
        EquilibriumError("the load steps become too small", 0.5, 1.0, "node 3"),
        AssemblyError("the pin of beam 0", 0.1, 0.2),
        ModesError("the iteration does not converge"),
        LoadError("the force on beam 0 failed", 0.1),
        OutputError("No space left on device", "run.h5", 0.1),
    ],
    ids=lambda failure: type(failure).__name__,
)
def test_every_failure_is_one_line_and_code_1(capsys, monkeypatch, failure):
    """`plan pull --error "3 %"` showed where in the package its plan had failed."""

    def fail(*_):
        raise failure

    monkeypatch.setattr(cli, "plan_scene", fail)
    code, out, err = run_command(capsys, "plan", "pull")
    assert (code, out, err) == (1, "", f"ancfsparse: {failure}\n")


def test_the_planned_pendulum_is_as_exact_as_the_paper_refined():
    result = compare_with_paper("l2t2", 1e-2)
    assert result.planned[1] <= 1e-2
    assert result.paper[1] <= 1e-2
    assert result.planning > 0.0
    assert "times as fast" in str(result)
