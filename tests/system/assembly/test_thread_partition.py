"""Elements dealt out to threads: every block once, no place twice, the same sums."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import chain, net
from ancfsparse.system import System
from ancfsparse.system.assembly.thread_partition import partition_elements
from tests.grids import level_grid


def square_mesh(n):
    """A net as one mesh."""
    nodes, edges, _ = level_grid(n, 4.0)
    scene = ancf.Scene(gravity=(0.0, 0.0, -9.81))
    mesh = scene.add_mesh(nodes, edges, "thin", ancf.Circle(0.01), ancf.Material(1e8, 1000.0))
    scene.pin(mesh.node(0))
    return scene


SCENES = {
    "chain": lambda: chain(5000).scene,
    "net": lambda: net(60).scene,
    "mesh": lambda: square_mesh(41),
}


@pytest.mark.parametrize(("name", "threads"), [("chain", 2), ("chain", 3), ("net", 2), ("mesh", 2)])
def test_parts_cover_all_and_share_nothing(name, threads):
    system = System(SCENES[name]())
    layouts = system.contributions[0].layouts
    run_start, runs = partition_elements(layouts, system.n_free, system.n_all, threads)
    seen = [np.zeros(len(layout.set_of), dtype=int) for layout in layouts]
    parts = [set() for _ in range(threads)]
    for part in range(threads + 1):
        for group, begin, end in runs[run_start[part] : run_start[part + 1]]:
            seen[group][begin:end] += 1
            layout = layouts[group]
            for b in range(begin, end):
                if part < threads:
                    shared = len(layout.table_of) > 0
                    table = layout.gather[layout.table_of[b] if shared else b]
                    parts[part].update((table + (layout.base[b] if shared else 0)).ravel())
    assert all((count == 1).all() for count in seen)
    for k, one in enumerate(parts):
        assert all(one.isdisjoint(other) for other in parts[:k])
    sizes = [len(part) for part in parts]
    assert min(sizes) > 0.7 * max(sizes)


@pytest.mark.parametrize("name", SCENES)
def test_divided_sums_are_the_same(name):
    alone, together = System(SCENES[name]()), System(SCENES[name]())
    assert together.contributions[0].divide(together.n_free, together.n_all, 2)
    together.assembly.set_threads(2)
    assert (alone.assembly.threads, together.assembly.threads) == (1, 2)
    rng = np.random.default_rng(20240704)
    q = alone.q0 + 1e-3 * rng.normal(size=alone.n_all)
    v, a = rng.normal(size=(2, alone.n_all))
    none = np.zeros(0)

    def results(system):
        assembly = system.assembly
        return (
            assembly.residual(q, v, a, none, system.dead_load, none)[0],
            assembly.matrix(1.0, 1e-7, q, none, none),
            assembly.force(q),
            assembly.inertia(a),
            np.array([assembly.strain_energy(q)]),
        )

    for one, other, again in zip(results(alone), results(together), results(together), strict=True):
        assert np.abs(one - other).max() <= 1e-13 * np.abs(one).max()
        np.testing.assert_array_equal(other, again)


def test_what_meets_everywhere_is_not_divided():
    # Elements that all end in one node.
    scene = ancf.Scene(gravity=(0.0, 0.0, -9.81))
    angle = np.linspace(0.0, 2.0 * np.pi, 65)[:-1]
    nodes = np.vstack([np.zeros(3), np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)])
    edges = np.stack([np.zeros(64, dtype=int), np.arange(1, 65)], axis=1)
    scene.add_mesh(nodes, edges, "thin", ancf.Circle(0.01), ancf.Material(1e8, 1000.0))
    system = System(scene)
    layouts = system.contributions[0].layouts
    assert partition_elements(layouts, system.n_free, system.n_all, 2) is None
