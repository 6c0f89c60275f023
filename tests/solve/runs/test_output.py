"""Long and large runs: chosen points, states in a file, and what cannot fit."""

import sys

import h5py
import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError, StepError
from ancfsparse.results.hdf5_reader import load
from ancfsparse.solve.preparation import memory_estimate
from ancfsparse.solve.stepping import state_recorder
from tests.beams import build_beam
from tests.solve.preparation.factors import cubic_lattice, seed_of

SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)


def swing(n=6, hold="", **options):
    """A cable on a rod, or a pin, which a force swings."""
    scene, rod = build_beam("thin", (0, 0), (2, 0), n, SECTION, MATERIAL, hold)
    if not hold:
        scene.rod(rod.start, (0, 1))
    scene.point_force(rod.end, lambda t: (np.sin(10 * t), 0.0))
    return scene, rod, ancf.simulate(scene, **{"t_end": 0.1, "dt": 1e-3, **options})


def same(run, other, points):
    np.testing.assert_array_equal(run.t, other.t)
    for point in points:
        for what in ("position", "velocity", "acceleration"):
            np.testing.assert_array_equal(getattr(run, what)(point), getattr(other, what)(point))


@pytest.mark.parametrize("save_every", [1, 7, 60, 1000])
@pytest.mark.parametrize("small_buffers", [False, True])
def test_a_file_holds_what_memory_would(tmp_path, save_every, small_buffers, monkeypatch):
    if small_buffers:
        monkeypatch.setattr(state_recorder, "BUFFER_BYTES", 1500)
        monkeypatch.setattr(
            sys.modules["ancfsparse.solve.motion.fixed_step_run"], "MAX_CHUNK_COORDINATES", 300
        )
    path = tmp_path / "run.h5"
    _, rod, run = swing(save_every=save_every, output=path)
    other_scene, twin, plain = swing(save_every=save_every)
    assert len(run.t) == -(-100 // save_every) + 1  # the last state in any case
    for name in ("q", "v", "a", "lam", "t"):
        np.testing.assert_array_equal(np.asarray(getattr(run, name)), getattr(plain, name))
    np.testing.assert_array_equal(run.position(rod.at(0.7)), plain.position(twin.at(0.7)))
    np.testing.assert_array_equal(run.slope(rod.end), plain.slope(twin.end))
    np.testing.assert_array_equal(run.reaction(rod.start), plain.reaction(twin.start))
    np.testing.assert_allclose(run.energy.total, plain.energy.total, rtol=1e-12, atol=1e-12)
    assert run.stats.steps == 100
    assert run.settings == plain.settings
    again = load(path, other_scene)
    same(again, plain, [twin.end, twin.at(0.3)])
    assert again.stats == run.stats


@pytest.mark.parametrize("to_file", [False, True])
def test_only_chosen_points_are_kept(tmp_path, to_file):
    scene, rod = build_beam("thin", (0, 0), (2, 0), 6, SECTION, MATERIAL, "pin")
    points = [rod.end, rod.at(0.3)]
    path = tmp_path / "run.h5" if to_file else None
    plain = ancf.simulate(scene, 0.05, 1e-3)
    run = ancf.simulate(scene, 0.05, 1e-3, save_nodes=points, output=path)
    same(run, plain, points)
    assert run.q.values.shape == (51, 10)
    assert run.q.shape == plain.q.shape
    assert "51 states" in repr(run)
    with pytest.raises(InputError, match="did not keep this: save_nodes keeps"):
        run.position(rod.node(4))
    with pytest.raises(InputError, match="did not keep this"):
        run.slope(rod.end)
    for ask in (lambda: run.energy, lambda: run.reaction(rod.start)):
        with pytest.raises(InputError, match="needs all coordinates"):
            ask()
    if to_file:
        same(load(path, scene), plain, points)


def test_nodes_of_a_mesh_can_be_kept():
    scene = ancf.Scene()
    nodes = [(0, 0), (1, 0), (2, 0), (1, 1), (1, -1)]
    net = scene.add_mesh(nodes, [(0, 1), (1, 2), (1, 3), (4, 1)], "l2t2", SECTION, MATERIAL)
    for k in (0, 2, 3):
        scene.pin(net.node(k))
    plain = ancf.simulate(scene, 0.02, 1e-3)
    run = ancf.simulate(scene, 0.02, 1e-3, save_nodes=[net.node(1), net.node(4)])
    same(run, plain, [net.node(1), net.node(4)])
    assert run.q.values.shape == (21, 4)


def test_a_file_of_another_scene_is_refused(tmp_path):
    path = tmp_path / "run.h5"
    swing(output=path)
    with pytest.raises(InputError, match=r"run.h5 was written for another scene"):
        load(path, swing(5)[0])
    (tmp_path / "text.h5").write_text("no")
    with h5py.File(tmp_path / "other.h5", "w"):
        pass
    whole = (tmp_path / "run.h5").read_bytes()
    (tmp_path / "cut.h5").write_bytes(whole[: len(whole) // 2])
    for name, message in (
        ("text.h5", "is not a file that simulate wrote$"),
        ("other.h5", "is not a file that simulate wrote$"),
        ("cut.h5", r"is cut off or damaged after \d+ bytes: copy it again"),
        ("none.h5", "there is no file .*none.h5: it was moved, removed or never written$"),
        (".", "is a folder: give the name of a file in it$"),
    ):
        with pytest.raises(InputError, match=message):
            load(tmp_path / name, swing()[0])


def test_a_failed_run_leaves_its_states_in_the_file(tmp_path):
    scene, rod = build_beam("thin", (0, 0), (2, 0), 4, SECTION, MATERIAL, "pin")
    scene.point_force(rod.end, lambda t: (0.0, 1e200 if t > 0.0105 else 0.0))
    with pytest.raises(StepError) as caught:
        ancf.simulate(scene, 0.02, 1e-3, output=tmp_path / "run.h5")
    assert len(caught.value.trajectory.t) == caught.value.step == 11
    np.testing.assert_array_equal(
        load(tmp_path / "run.h5", scene).position(rod.end),
        caught.value.trajectory.position(rod.end),
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"save_nodes": 3}, r"save_nodes must be a list such as \[rod.end\], got 3"),
        ({"save_nodes": [3]}, "save_nodes must hold points such as rod.end, got 3"),
        ({"save_nodes": []}, "save_nodes must be a list such as"),
        ({"output": 3}, "output must be the name of a file such as 'run.h5', got 3"),
        ({"output": "/no/such/place/run.h5"}, "cannot be written: there is no folder /no/such"),
        ({"output": "/"}, "output '/' cannot be written"),
    ],
)
def test_bad_output(options, message):
    with pytest.raises(InputError, match=message):
        swing(**options)


def test_a_run_that_cannot_fit_is_refused_before_it_starts(monkeypatch):
    monkeypatch.setattr(memory_estimate, "available_memory", lambda: 2e9)
    message = (
        r"about 24\.\d GB, more than there is: 2 GB of memory are free, and saved states alone "
        r"would take 24\.\d GB; try a larger save_every, save_nodes=\[...\], or output="
    )
    with pytest.raises(InputError, match=message):
        swing(100, t_end=2.5e3)
    scene, _ = build_beam("l2t2", (0, 0), (2e3, 0), 30000, SECTION, MATERIAL, "pin")
    full = ancf.QuasiNewton("bfgs", memory="full")
    with pytest.raises(InputError, match=r"factor or inverse alone would take .* GB; try fewer"):
        ancf.simulate(scene, 1.0, 1e-3, save_every=1000, solver=full)
    monkeypatch.setattr(memory_estimate, "available_memory", lambda: None)
    swing()


def test_a_lattice_whose_factor_cannot_fit_is_refused_before_it_is_factored(monkeypatch):
    scene = cubic_lattice(13)
    estimated = memory_estimate.estimate_memory(scene, 2, 1, False, "auto")
    seed = seed_of(scene)
    assert seed.nbytes > 2.0 * estimated.factor  # what a plane net of as many nodes would take
    monkeypatch.setattr(memory_estimate, "available_memory", lambda: estimated.total + 1e6)
    with pytest.raises(InputError, match=r"the factor or inverse alone would take .* GB; try few"):
        ancf.simulate(scene, 1e-3, 1e-3, factorization="complete")
    with pytest.raises(InputError, match=r"the factor or inverse alone would take .* GB; try few"):
        ancf.simulate(scene, 1e-4, 1e-5, integrator=ancf.CentralDifference())


def test_the_memory_of_a_factor_is_known_before_it_is_made():
    swinging = (swing(3000, hold, t_end=1e-3)[0] for hold in ("", "pin"))
    for scene in (*swinging, cubic_lattice(9)):
        seed = seed_of(scene)
        assert seed.nbytes == pytest.approx(seed.own.nbytes, rel=0.5)


def test_a_beam_that_cannot_fit_is_refused_before_it_is_made():
    scene = ancf.Scene()
    text = r"^beam 0, 1000000000000 elements, would need about 5.2e\+04 GB, more than there is: .*"
    with pytest.raises(InputError, match=text + "GB of memory are free; try a smaller n_elements$"):
        scene.add_beam("thin", (0, 0), (2, 0), 10**12, SECTION, MATERIAL)


def test_a_limit_on_addresses_counts():
    resource = pytest.importorskip("resource")
    limits = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (2**40, limits[1]))
    try:
        assert memory_estimate.available_memory() < 2**40
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limits)


def test_what_is_free_is_known_here():
    free = memory_estimate.available_memory()
    assert free is None or 0 < free < 1e14
