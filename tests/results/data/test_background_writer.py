"""Blocks of states that a thread writes: the file, and errors, are those without the thread."""

import errno
import os
import threading
import uuid

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import OutputError
from ancfsparse.results import RunStats
from ancfsparse.results.export import background_writer, hdf5_writer
from ancfsparse.results.export.background_writer import BackgroundWriter
from ancfsparse.results.export.hdf5_writer import Writer
from tests.beams import build_beam

N, M, H = 3000, 7, 5  # coordinates, multipliers, history variables
NEVER = 2**60  # bytes that no block has


@pytest.fixture
def in_thread(monkeypatch):
    monkeypatch.setattr(background_writer, "MIN_THREAD_BYTES", 0)


def blocks(rng, sizes=(1, 4, 9, 1, 30)):
    begin = 0
    for size in sizes:
        yield (
            np.arange(begin, begin + size) + 0.0,
            *(rng.normal(size=(size, width)) for width in (N, N, N, M, H)),
        )
        begin += size


def write(path, rng):
    """Write blocks from two buffers in turn, as runs do; return which the main thread wrote."""
    by_main, append = [], Writer.append
    buffers = [[np.empty((30, width)) for width in (N, N, N, M, H)] for _ in range(2)]

    def noted(*block, **where):
        by_main.append(threading.current_thread() is threading.main_thread())
        append(*block, **where)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(uuid, "uuid4", lambda: uuid.UUID(int=1))
        patch.setattr(Writer, "append", noted)
        with Writer(path, N, M, None, {}, {}, H) as writer, BackgroundWriter(writer) as recorder:
            rows = 0
            for t, *tables in blocks(rng):
                for buffer, table in zip(buffers[0], tables, strict=True):
                    buffer[: len(t)] = table
                if recorder.append(t, *(buffer[: len(t)] for buffer in buffers[0])):
                    buffers.reverse()
                rows += len(t)
                assert recorder.rows == rows
            recorder.keep_checkpoint(b"state")
            recorder.append(t[:2] + 50.0, *(table[:2] for table in tables), begin=20)
            assert recorder.rows == 22
            recorder.finish(RunStats())
    return by_main


def test_the_file_is_equal_to_the_bit_with_and_without_the_thread(tmp_path, monkeypatch):
    contents = []
    for thread_bytes in (0, NEVER):
        monkeypatch.setattr(background_writer, "MIN_THREAD_BYTES", thread_bytes)
        path = tmp_path / f"{thread_bytes}.h5"
        by_main = write(path, np.random.default_rng(3))
        assert by_main == [thread_bytes == NEVER] * 5 + [True]
        checkpoint = path.with_name(f"{path.name}.checkpoint")
        contents.append((path.read_bytes(), checkpoint.read_bytes()))
    assert contents[0] == contents[1]
    assert len(contents[0][0]) > 45 * 3 * 8 * N


@pytest.mark.usefixtures("in_thread")
def test_a_run_has_the_states_of_one_in_memory(tmp_path):
    section, material = ancf.Circle(0.01), ancf.Material(1e8, 4000.0)
    scene, _ = build_beam("thin", (0, 0), (2, 0), 20, section, material, "pin")
    options = {"integrator": ancf.Newmark(), "save_every": 3, "t_end": 3.1, "dt": 1e-3}
    run = ancf.simulate(scene, output=tmp_path / "run.h5", **options)
    plain = ancf.simulate(scene, **options)
    for name in "tqva":
        np.testing.assert_array_equal(getattr(run, name)[:], getattr(plain, name))
    assert run.stats.steps == 3100


@pytest.mark.usefixtures("in_thread")
def test_an_error_of_the_thread_is_raised_by_the_next_call(tmp_path, monkeypatch, rng):
    given = list(blocks(rng))

    def full(*_):
        raise OSError(errno.ENOSPC, "")

    with Writer(tmp_path / "run.h5", N, M, None, {}, {}, H) as writer:
        with BackgroundWriter(writer) as recorder:
            recorder.append(*given[0])
            recorder.append(*given[1])
            recorder._wait()
            with monkeypatch.context() as patch:
                patch.setattr(hdf5_writer, "allocate_disk", full)
                assert recorder.append(*given[2])
                with pytest.raises(OutputError, match="the states after t = 4 s: No space left"):
                    recorder.append(*given[3])
            assert recorder.rows == 5
            with pytest.raises(OutputError):  # not after the states that are missing
                recorder.append(*given[3])
            recorder.finish(RunStats(steps=9))
        assert "stats" in writer._file


@pytest.mark.usefixtures("in_thread")
def test_an_error_in_the_last_block_is_raised_at_the_end(tmp_path, monkeypatch, rng):
    (block,) = blocks(rng, [3])
    with Writer(tmp_path / "run.h5", N, M, None, {}, {}, H) as writer:
        monkeypatch.setattr(writer, "_reserve", lambda _: 1 // 0)
        with pytest.raises(ZeroDivisionError), BackgroundWriter(writer) as recorder:
            recorder.append(*block)
        assert recorder.rows == 0


@pytest.mark.usefixtures("in_thread")
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_process_that_is_forked_during_a_write_does_not_wait_for_it(tmp_path, monkeypatch, rng):
    begun, may_end, append = threading.Event(), threading.Event(), Writer.append

    def waiting(*block):
        begun.set()
        may_end.wait()
        append(*block)

    monkeypatch.setattr(Writer, "append", waiting)
    (block,) = blocks(rng, [3])
    with Writer(tmp_path / "run.h5", N, M, None, {}, {}, H) as writer:
        with BackgroundWriter(writer) as recorder:
            recorder.append(*block)
            begun.wait()
            child = os.fork()
            if not child:
                recorder._wait()
                os._exit(recorder.rows)
            assert os.waitpid(child, 0)[1] == 0
            may_end.set()
        assert writer.rows == 3
