"""The tool that compares two builds: a build beside itself takes the same counts."""

import json
import subprocess
import sys

from tests.paths import ROOT

TOOL = ROOT / "tools" / "compare_builds.py"


def test_build_beside_itself_has_equal_counts(tmp_path):
    chosen = ["--cases", "L2T2 10, rest, Newton", "--rounds", "2", "--repeats", "1"]
    out = tmp_path / "rows.json"
    command = [sys.executable, "-P", str(TOOL), sys.executable, *chosen, "--json", str(out)]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    paper, default = json.loads(out.read_text())
    assert paper["case"] == "L2T2 10, rest, Newton, paper"
    assert default["case"] == "L2T2 10, rest, Newton, default"
    for row in (paper, default):
        assert row["case"] in text
        assert row["this_seconds"] > 0.0 < row["other_seconds"]
        for count in ("iterations", "residual_evaluations", "factorizations"):
            assert row[f"this_{count}"] == row[f"other_{count}"] >= 1.0
    assert paper["this_residual_evaluations"] == paper["this_iterations"] + 1.0


def test_cases_that_are_not_there_are_named():
    command = [sys.executable, "-P", str(TOOL), sys.executable, "--cases", "piano"]
    run = subprocess.run(command, check=False, capture_output=True, text=True)
    assert run.returncode == 2
    assert "no case contains 'piano'" in run.stderr
