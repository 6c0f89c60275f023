"""Runs that end early, by a load that fails or from outside, keep every accepted step and count."""

import signal
import sys
import threading

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import LoadError
from ancfsparse.integrators import CentralDifference, EnergyMomentum, RungeKuttaNystrom
from ancfsparse.results.export import background_writer
from ancfsparse.results.export.background_writer import BackgroundWriter
from ancfsparse.results.export.hdf5_writer import Writer
from ancfsparse.results.hdf5_reader import load
from ancfsparse.solve.motion import fixed_step_run
from ancfsparse.solve.stepping import file_recording, state_recorder
from tests.beams import build_beam

SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)


def pendulum(force=None, n=3):
    scene, rod = build_beam("thin", (0, 0), (2, 0), n, SECTION, MATERIAL, "pin")
    if force is not None:
        scene.point_force(rod.end, force)
    return scene, rod


def fails(t):
    if t > 0.49005:
        raise OSError("sensor table ends")
    return (0.0, 1.0)


@pytest.mark.parametrize(
    ("force", "message"),
    [
        (fails, "failed at t = 0.4901 s: OSError: sensor table ends. The states up"),
        (lambda t: (0.0, np.where(t > 0.49005, np.nan, 1.0)), "must be finite, but its y comp"),
        (lambda t: (0.0, 1.0) if t < 0.49005 else (0.0, 1.0, 0.0), "has 3 components"),
        (ancf.Table([0.0, 0.49005], [(0.0, 1.0)] * 2), "the table has values from t = 0 s to 0.4"),
    ],
    ids=["raises", "nan in arrays", "shape", "table"],
)
@pytest.mark.parametrize("to_file", [False, True])
def test_a_load_that_fails_late_leaves_everything_before(tmp_path, force, message, to_file):
    scene, rod = pendulum(force)
    path = tmp_path / "run.h5" if to_file else None
    with pytest.raises(LoadError, match=message) as caught:
        ancf.simulate(scene, 0.5, 1e-4, output=path)
    assert caught.value.time == pytest.approx(0.4901)
    run = caught.value.trajectory
    assert run.stats.steps == 4900
    assert run.stats.iterations >= 4900
    assert not run.finished
    whole = ancf.simulate(pendulum((0.0, 1.0))[0], 0.49, 1e-4)
    np.testing.assert_allclose(run.t, whole.t, rtol=1e-15)
    np.testing.assert_allclose(run.q[-1], whole.q[-1], rtol=0.0, atol=1e-9)
    assert run.energy.drift < 1e-3  # the loads at these times are known
    if to_file:
        again = load(path, scene)
        assert repr(again.stats) == repr(run.stats)
        np.testing.assert_array_equal(again.position(rod.end), run.position(rod.end))


@pytest.mark.parametrize(
    ("integrator", "dt"),
    [
        (ancf.Newmark(0.0), 1e-3),
        (EnergyMomentum(), 1e-3),
        (CentralDifference(), 1e-4),
        (RungeKuttaNystrom(8), 1e-3),
    ],
)
@pytest.mark.parametrize("save_every", [1, 7, 10000])
def test_the_last_step_before_the_failure_is_recorded(integrator, dt, save_every):
    scene, _ = pendulum(lambda t: (0.0, 1.0) if t < 0.0595 else (0.0, "x"))
    with pytest.raises(LoadError, match="must be 2 numbers") as caught:
        ancf.simulate(scene, 0.1, dt, integrator=integrator, save_every=save_every)
    run, n = caught.value.trajectory, round(0.0595 / dt - 0.6)
    assert run.stats.steps == n
    np.testing.assert_allclose(run.t, dt * np.unique(np.append(np.arange(0, n, save_every), n)))


def test_a_load_that_fails_at_once_leaves_the_start():
    scene, _ = pendulum(lambda t: (0.0, 1.0) if t < 1.5e-3 else (0.0, np.inf))
    with pytest.raises(LoadError) as caught:
        ancf.simulate(scene, 0.1, 1e-3)
    assert len(caught.value.trajectory.t) == 2
    scene, _ = pendulum(lambda t: (0.0, np.inf) if t > 0 else (0.0, 1.0))
    with pytest.raises(LoadError, match="must be finite") as caught:
        ancf.simulate(scene, 0.1, 1e-3)
    assert caught.value.trajectory is None


class Halt(Exception):
    """What a handler raises."""


@pytest.fixture
def alarm():
    """Raise an error from a signal, some time from now."""

    def after(seconds, error):
        def handler(*_):
            raise error

        signal.signal(signal.SIGALRM, handler)
        signal.setitimer(signal.ITIMER_REAL, seconds)

    before = signal.getsignal(signal.SIGALRM)
    yield after
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs timers")
@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), CentralDifference()])
@pytest.mark.parametrize(("error", "words"), [(KeyboardInterrupt, "interrupted"), (Halt, "ended")])
def test_signals_are_answered_between_two_steps(
    tmp_path, monkeypatch, alarm, integrator, error, words
):
    # All steps in one go, which takes many seconds.
    monkeypatch.setattr(fixed_step_run, "MAX_CHUNK", 10**9)
    monkeypatch.setattr(fixed_step_run, "MAX_CHUNK_COORDINATES", 10**12)
    scene, rod = pendulum(n=50)
    n = 1_000_000

    advance = fixed_step_run.FixedStepRun._advance

    def started(self, end):
        alarm(0.3, error)
        return advance(self, end)

    monkeypatch.setattr(fixed_step_run.FixedStepRun, "_advance", started)
    with pytest.raises(error) as caught:
        ancf.simulate(
            scene, n * 1e-5, 1e-5, integrator=integrator, save_every=1000, save_nodes=[rod.end],
            output=tmp_path / "run.h5",
        )  # fmt: skip
    run = load(tmp_path / "run.h5", scene)
    steps = run.stats.steps
    assert steps < n
    assert run.stats.residual_evaluations >= steps
    assert run.t[-1] == pytest.approx(steps * 1e-5)
    assert len(run.t) == 1 + -(-steps // 1000)
    assert repr(caught.value.trajectory) == repr(run)
    assert f"The run was {words}: its states up to t = " in caught.value.__notes__[0]


def test_threads_without_signals_run_as_ever():
    runs = []
    scene, _ = pendulum(n=50)
    thread = threading.Thread(target=lambda: runs.append(ancf.simulate(scene, 0.2, 1e-4)))
    thread.start()
    thread.join()
    assert runs[0].finished


class Interrupter:
    """Raise KeyboardInterrupt at the n-th line of what hands states and counts on."""

    def __init__(self, n):
        self.left, self.time_loop = n, None

    def __call__(self, frame, event, _):
        name, me = frame.f_code.co_name, frame.f_locals.get("self")
        steps = isinstance(me, fixed_step_run.FixedStepRun) and name != "__init__"
        kept = isinstance(me, (state_recorder.MemoryRecorder, BackgroundWriter, Writer))
        if not steps and not (kept and name in ("append", "finish", "_reserve")):
            return None
        if steps and getattr(me, "recorder", None) is not None and me.recorder.rows:
            self.time_loop = me._time_loop  # the start is recorded
        if self.time_loop is not None and event == "line":
            self.left -= 1
            if self.left == 0:
                raise KeyboardInterrupt
        return self


@pytest.mark.parametrize(
    ("to_file", "thread_bytes"),
    [(False, 0), (True, 2**20), (True, 0)],
    ids=["memory", "file", "thread"],
)
def test_no_step_is_lost_wherever_an_interruption_comes(
    tmp_path, monkeypatch, to_file, thread_bytes
):
    monkeypatch.setattr(fixed_step_run, "MAX_CHUNK", 35)
    monkeypatch.setattr(background_writer, "MIN_THREAD_BYTES", thread_bytes)
    scene, _ = pendulum(lambda t: (0.0, 1.0 + t))
    options = {"save_every": 10, "output": tmp_path / "run.h5" if to_file else None}
    whole = np.asarray(ancf.simulate(scene, 0.1, 1e-3).q)
    places = 0
    for n in range(1, 10_000, 5):
        interrupter, before = Interrupter(n), sys.gettrace()
        try:
            sys.settrace(interrupter)
            ancf.simulate(scene, 0.1, 1e-3, **options)
        except KeyboardInterrupt as stop:
            sys.settrace(before)
            run = stop.trajectory
            steps = run.stats.steps
            assert steps == interrupter.time_loop.steps
            numbers = np.unique(np.append(np.arange(0, steps, 10), steps))
            np.testing.assert_allclose(run.t, 1e-3 * numbers)
            np.testing.assert_array_equal(np.asarray(run.q), whole[numbers])
            places += 1
        else:
            break
        finally:
            sys.settrace(before)
    assert places > 20


def test_an_interruption_after_the_last_step_takes_the_whole_run_along(tmp_path, monkeypatch):
    calls, read = [], file_recording.read_run

    def interrupted(*arguments):
        calls.append(arguments)
        if len(calls) == 1:
            raise KeyboardInterrupt
        return read(*arguments)

    monkeypatch.setattr(file_recording, "read_run", interrupted)
    scene, _ = pendulum()
    with pytest.raises(KeyboardInterrupt) as caught:
        ancf.simulate(scene, 0.1, 1e-3, output=tmp_path / "run.h5")
    assert len(caught.value.trajectory.t) == 101
    assert caught.value.trajectory.finished
    assert "its states up to t = 0.1 s are in the attribute" in caught.value.__notes__[0]
