"""Files of killed runs are held to the states that were passed on, neither fewer nor more."""

import shutil

import pytest

import ancfsparse as ancf
from ancfsparse.results.export.hdf5_writer import Writer
from tests.soak.trials.interruptions import DT, EVERY, judged, pendulum


@pytest.fixture
def begun(tmp_path, monkeypatch):
    """Return the file of a run that is killed before it passes on its first state."""
    path = tmp_path / "begun.h5"

    def killed(writer, *_, **where):
        shutil.copy(tmp_path / "run.h5", path)
        raise KeyboardInterrupt

    with monkeypatch.context() as at_first:
        at_first.setattr(Writer, "append", killed)
        with pytest.raises(KeyboardInterrupt):
            ancf.simulate(pendulum(), 20 * DT, DT, output=tmp_path / "run.h5")
    return path


def test_a_run_that_passed_on_no_state_has_lost_none(begun):
    assert begun.stat().st_size > 10_000
    assert judged(begun, "a kill", 0, []) == []


def test_a_file_without_the_states_that_were_passed_on_is_a_find(begun):
    (find,) = judged(begun, "a kill", 0, [1])
    assert find.startswith("its file cannot be read")


@pytest.mark.parametrize(
    ("passed", "finds"),
    [
        ([1, 201], []),
        ([1], []),
        ([1, 201, 401], ["401 states were passed on and the file has 201"]),
        ([201], ["states were passed on in greater numbers than 200: [0, 201]"]),
    ],
)
def test_files_are_held_to_what_was_passed_on(tmp_path, passed, finds):
    path = tmp_path / "run.h5"
    ancf.simulate(pendulum(), 2000 * DT, DT, save_every=EVERY, output=path)
    assert judged(path, "a kill", 0, passed) == finds
