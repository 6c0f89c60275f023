"""The command: what it prints, what it refuses and how it leaves."""

import json
import re

import numpy as np
import pytest

from ancfsparse import Newmark, QuasiNewton, simulate
from ancfsparse.problems import pendulum
from tests.cli.command import run

SHORT = ("pendulum", "--time", "0.01", "--json", "-")


def test_json_is_one_object_with_everything_asked_for(capsys):
    code, out, err = run(capsys, *SHORT, "--element", "thin", "--elements", "10", "--step", "5e-4",
                         "--solver", "davidon", "--memory", "full", "--alpha", "0")  # fmt: skip
    assert (code, err) == (0, "")
    data = json.loads(out)
    assert list(data) == [
        "time", "tip", "march_seconds", "steps", "iterations", "residual_evaluations",
        "factorizations", "energy_drift", "settings",
    ]  # fmt: skip
    assert data["time"][0] == 0.0
    np.testing.assert_allclose(data["time"], 5e-4 * np.arange(21), rtol=0, atol=1e-15)
    assert np.shape(data["tip"]) == (21, 2)
    assert data["tip"][0] == [2.0, 0.0]
    assert data["steps"] == 20
    assert data["residual_evaluations"] == data["iterations"] + data["steps"]
    assert data["factorizations"] == 1
    assert data["march_seconds"] > 0.0
    assert 0.0 <= data["energy_drift"] < 1e-2
    assert data["settings"]["solver"] == "davidon"
    assert data["settings"]["tolerance"] == "paper"
    assert data["settings"]["dim"] == 2


def test_tip_is_that_of_the_same_run_in_python(capsys):
    _, out, _ = run(capsys, *SHORT, "--solver", "bfgs", "--memory", "5", "--tolerance", "1e-6")
    problem = pendulum("thin")
    same = simulate(problem.scene, 0.01, 5e-4, solver=QuasiNewton("bfgs", memory=5), tolerance=1e-6,
                    integrator=Newmark())  # fmt: skip
    assert json.loads(out)["tip"] == same.position(problem.rod.end).tolist()


def test_every_nth_state_is_saved(capsys):
    data = json.loads(run(capsys, *SHORT, "--save-every", "5")[1])
    np.testing.assert_allclose(data["time"], 5 * 5e-4 * np.arange(5), rtol=0, atol=1e-15)
    assert len(data["tip"]) == 5
    assert data["steps"] == 20


@pytest.mark.parametrize(
    "solver", ["newton", "modified-newton", "broyden", "davidon", "dfp", "bfgs", "auto"]
)
def test_every_solver_finds_the_same_tip(capsys, solver):
    data = json.loads(run(capsys, *SHORT, "--solver", solver, "--tolerance", "1e-6")[1])
    newton = json.loads(run(capsys, *SHORT, "--solver", "newton", "--tolerance", "1e-9")[1])
    np.testing.assert_allclose(data["tip"], newton["tip"], rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    ("words", "dim"),
    [
        (("--element", "l2t2"), 2),
        (("--element", "thin", "--dim", "3"), 3),
        (("--element", "thin", "--strain", "biot"), 2),
        (("--element", "thick"), 3),
        (("--element", "thick", "--dim", "2", "--section-strain", "nodal"), 2),
        (("--element", "thick", "--curvature", "section", "--nu", "0.2"), 3),
    ],
)
def test_every_element_runs_in_its_dimensions(capsys, words, dim):
    code, out, err = run(capsys, *SHORT, *words)
    assert (code, err) == (0, "")
    data = json.loads(out)
    assert np.shape(data["tip"]) == (21, dim)
    assert data["settings"]["dim"] == dim


def test_summary_says_where_the_tip_is(capsys):
    code, out, _ = run(capsys, "pendulum", "--time", "0.01")
    assert code == 0
    assert "20 steps" in out
    assert "tip at t = 0.01 s" in out


def test_json_goes_to_a_file(capsys, tmp_path):
    code, out, _ = run(capsys, *SHORT[:-1], str(tmp_path / "run.json"))
    assert (code, out) == (0, "")
    assert json.loads((tmp_path / "run.json").read_text())["steps"] == 20


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--element", "thik"), "did you mean 'thick'"),
        (("--elements", "0"), "at least 1"),
        (("--dim", "4"), "dim must be 2"),
        (("--element", "l2t2", "--dim", "3"), "planar element"),
        (("--element", "l2t2", "--strain", "biot"), "no option strain"),
        (("--strain", "biott"), "did you mean 'biot'"),
        (("--step", "0"), "--step must be positive"),
        (("--step", "nan"), "--step must be finite"),
        (("--step", "3e-4"), "does not divide"),
        (("--time", "-1"), "--time must be positive"),
        (("--solver", "davidson"), "did you mean 'davidon'"),
        (("--memory", "half"), "memory must be 'full' or a number"),
        (("--memory", "2.5"), "integral number of pairs"),
        (("--memory", "0"), "at least 1"),
        (("--alpha", "2"), "alpha"),
        (("--tolerance", "tight"), "tolerance must be 'paper' or 'default' or a number"),
        (("--tolerance", "-1"), "must be positive"),
        (("--save-every", "0"), "--save-every must be"),
        (("--json", "nowhere/run.json"), "there is no folder"),
        (("--integrator", "verlet"), "unknown integrator 'verlet'"),
    ],
)
def test_what_cannot_be_meant_is_one_sentence_and_code_2(capsys, words, sentence):
    code, out, err = run(capsys, "pendulum", "--time", "0.01", *words)
    assert (code, out) == (2, "")
    assert err.startswith("ancfsparse: ")
    assert err.count("\n") == 1
    assert sentence in err


def test_step_that_fails_is_one_sentence_and_code_1(capsys):
    code, out, err = run(capsys, "pendulum", "--time", "20", "--step", "2", "--elements", "4")
    assert (code, out) == (1, "")
    assert err.count("\n") == 1
    assert "a smaller --step" in err


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (("--integrator", "hht", "--alpha", "0.1"), "quasi-Newton (davidon, full memory)"),
        (("--integrator", "generalized-alpha", "--rho-inf", "0.8"), "quasi-Newton (davidon, full"),
        (("--integrator", "energy-momentum"), "quasi-Newton (davidon, full memory)"),
        (("--integrator", "central-difference", "--step", "2e-4"), "CentralDifference()"),
        (("--integrator", "rkn8", "--step", "2.5e-4"), "RungeKuttaNystrom(order=8)"),
        (("--integrator", "dormand-prince", "--step", "5e-4"), "DormandPrince()"),
    ],
)
def test_integrators_by_name_agree(capsys, words, name):
    _, out, _ = run(capsys, *SHORT, *words)
    found = json.loads(out)
    _, out, _ = run(capsys, *SHORT)
    np.testing.assert_allclose(found["tip"][-1], json.loads(out)["tip"][-1], atol=1e-7)
    assert found["settings"]["chosen"].startswith(name)


def test_an_accuracy_is_asked_for_and_told(capsys):
    code, out, _ = run(capsys, *SHORT, "--accuracy", "1e-6", "--step", "1e-3",
                       "--integrator", "generalized-alpha")  # fmt: skip
    data = json.loads(out)
    assert code == 0
    assert 0.0 < data["estimated_error"] <= 1e-6
    assert len(data["time"]) == 11
    assert data["settings"]["solver"] == "auto"
    assert "modified Newton" in data["settings"]["chosen"]


def test_a_run_to_an_accuracy_names_the_integrator_it_took(capsys):
    words = "pendulum --elements 4 --time 0.05 --accuracy 1e-6 --step 5e-3".split()
    _, out, _ = run(capsys, *words)
    assert re.search(
        r"(CentralDifference|RungeKuttaNystrom|GeneralizedAlpha)\(.*\).* in \d+ steps", out
    )
    _, out, _ = run(capsys, *words, "--json", "-")
    settings = json.loads(out)["settings"]
    assert settings["integrator"] == "auto"
    assert settings["chosen"] in out
    code, _, err = run(capsys, *words, "--rho-inf", "0.8")
    assert (code, "--integrator auto: leave it out" in err) == (2, True)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--alpha", ".3", "--integrator", "generalized-alpha"),
         "--alpha 0.3 does not apply to --integrator generalized-alpha: leave it out, or take "
         "--integrator newmark or hht"),
        (("--rho-inf", ".5"), "--rho-inf 0.5 does not apply to --integrator newmark"),
        (("--memory", "5", "--solver", "newton"), "--memory 5 does not apply to --solver newton: "),
        (("--memory", "5", "--accuracy", "1e-3", "--integrator", "hht"),
         "--memory 5 does not apply to --solver auto, the default here"),
        (("--solver", "newton", "--integrator", "central-difference"),
         "--solver newton does not apply to --integrator central-difference: leave it out"),
        (("--tolerance", "1e-3", "--integrator", "rkn4"), "--tolerance 1e-3 does not apply to"),
        (("--solver", "bfgs", "--accuracy", "1e-3", "--integrator", "hht"),
         "--solver bfgs with full memory keeps its first one: add --memory 10"),
        (("--factorization", "complete", "--integrator", "rkn4"),
         "--factorization complete does not apply to"),
        (("--factorization", "best"), "unknown factorization 'best'"),
        (("--factorization", "incomplete"),
         "the full memory of --solver davidon, the default here, starts"),
        (("--factorization", "incomplete", "--accuracy", "1e-3"),
         "leave out --factorization incomplete"),
        (("--nu", ".4"), "--nu 0.4 does not apply to --element thin: leave it out, or take "
         "--element thick"),
    ],
)  # fmt: skip
def test_an_option_that_nothing_hears_is_refused(capsys, words, sentence):
    code, out, err = run(capsys, *SHORT, *words)
    assert (code, out) == (2, "")
    assert sentence in err


def test_a_seed_that_is_asked_for_is_taken(capsys):
    _, out, _ = run(capsys, *SHORT, "--solver", "modified-newton", "--factorization", "incomplete")
    assert "with an incomplete factorization" in json.loads(out)["settings"]["chosen"]


def test_settings_are_those_that_were_heard(capsys):
    settings = json.loads(run(capsys, *SHORT)[1])["settings"]
    assert (settings["alpha"], settings["memory"]) == (0.0, "full")
    assert settings["rho_inf"] is settings["nu"] is None


@pytest.mark.parametrize(
    "words",
    [
        ("--time", "20", "--step", "2", "--elements", "4"),
        ("--step", "0.1", "--solver", "newton"),
        ("--step", "0.1"),
        ("--time", "0.1", "--step", "1e-3", "--integrator", "rkn4"),
        ("--time", "0.01", "--step", "3e-4"),
        ("--time", "0.01", "--step", "0"),
        ("--accuracy", "1e9", "--integrator", "hht"),
        ("--accuracy", "1e-3"),
        ("--accuracy", "1e-3", "--integrator", "newmark", "--alpha", ".1"),
    ],
)
def test_failures_speak_of_options_of_the_command(capsys, words):
    code, _, err = run(capsys, "pendulum", *words)
    if code:
        assert not re.search(r"max_|trajectory|(?<!-)dt\b(?! = .* s\))|t_end|(?<!-)accuracy=", err)
        assert re.search(r"--(step|time|accuracy|integrator)", err)


def test_version_is_told(capsys):
    code, out, _ = run(capsys, "--version")
    assert code == 0
    assert re.fullmatch(r"ancfsparse \d+\.\d+\.\d+\n", out)
