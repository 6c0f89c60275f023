"""Threads share the work of large systems and change nothing but the last digits."""

import numpy as np
import pytest

from ancfsparse import InputError, QuasiNewton, simulate
from ancfsparse.problems import chain, net, pile


@pytest.mark.parametrize("solver", ["auto", QuasiNewton("broyden", memory=3)])
def test_runs_with_the_same_threads_are_the_same_bits(solver):
    def run(threads):
        scene, rod = chain(12_000, "rough")
        options = {"solver": solver, "threads": threads, "save_nodes": [rod.at(0.4), rod.end]}
        path = simulate(scene, 3e-3, 5e-4, **options)
        assert path.system.assembly.threads == threads
        return path.stats, np.array([path.position(rod.at(0.4)), path.position(rod.end)])

    (alone, moved), (one, moved_one), (other, moved_other) = run(1), run(2), run(2)
    assert (alone.threads, one.threads) == (1, 2)
    np.testing.assert_array_equal(moved_one, moved_other)
    assert one.iterations == other.iterations == alone.iterations
    assert np.abs(moved_one - moved).max() < 1e-9


def test_small_systems_stay_on_one_thread():
    scene = chain(10).scene
    run = simulate(scene, 1e-2, 1e-3, threads=2)
    assert run.stats.threads == 1
    np.testing.assert_array_equal(run.q, simulate(chain(10).scene, 1e-2, 1e-3).q)


def test_heaps_of_beams_use_threads_from_fewer_coordinates():
    runs = [
        simulate(pile(70, 0.4, width=1.4, cables_in_layer=10).scene, 2e-3, 1e-3, threads=n)
        for n in (1, 2)
    ]
    assert [run.stats.threads for run in runs] == [1, 2]
    np.testing.assert_allclose(runs[1].q, runs[0].q, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("threads", [0, -1, 1.5, "all", 257])
def test_a_bad_number_is_refused(threads):
    with pytest.raises(InputError, match="threads"):
        simulate(chain(10).scene, 1e-2, 1e-3, threads=threads)


def test_a_net_on_two_threads_moves_as_on_one():
    runs = [simulate(net(70).scene, 2e-3, 1e-3, threads=threads) for threads in (1, 2)]
    assert [run.stats.threads for run in runs] == [1, 2]
    assert np.abs(runs[0].q - runs[1].q).max() < 1e-12
