"""The race against Exudyn, and what happens without it."""

import json
import sys

import numpy as np
import pytest

from benchmarks.commands import main
from benchmarks.common.files import plain
from benchmarks.table1.speed import bench_paper


def test_missing_exudyn_is_one_clear_sentence(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "exudyn", None)
    with pytest.raises(SystemExit) as left:
        main(["bench-paper"])
    assert left.value.code == 2
    err = capsys.readouterr().err
    assert "pip install 'ancfsparse[peers]'" in err
    assert err.count("\n") == 1


def test_same_discretisation_gives_the_same_motion():
    pytest.importorskip("exudyn")
    result = bench_paper(t_end=0.5, repeats=1)
    assert result.tip_difference < 1e-6
    ours, theirs = result.contestants[1], result.contestants[2]
    assert ours.name == "Thin biot, Davidon"
    assert theirs.tip.shape == (1, 2)
    np.testing.assert_allclose(ours.tip, theirs.tip, rtol=0, atol=1e-6)
    assert len(result.speed_ups) == 12
    assert "Exudyn's best / L2T2" in str(result)
    assert len(json.loads(json.dumps(plain(result)))["targets"]) == 5
