"""The examples of README.md run as they stand, to the numbers that the equations give."""

import re

import numpy as np
import pytest

import ancfsparse as ancf
from tests.paths import ROOT
from tools.run_readme import OPTIONAL

README = ROOT / "README.md"
BLOCKS = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
FIRST = BLOCKS[0]


def run(*sources):
    """Run examples of the page one after the other; return their names."""
    names = {}
    exec(compile("".join(sources), "README.md", "exec"), names)
    return names


def block_with(word):
    """Return the example that contains a word."""
    (found,) = (block for block in BLOCKS if word in block)
    return found


@pytest.mark.parametrize("method", ["run", "paper"])
def test_first_example_reaches_the_reference_positions(method):
    names = run(FIRST, block_with("davidon"))
    path, rod = names[method], names["rod"]

    # Tip of the planar thin pendulum, 10 elements, exact in time (an 8th-order integrator run at
    # two tolerances, which agree to 1e-12 m); the bound is for a method of order 2 at this step.
    for t, tip in {
        0.5: (1.311527427649, -1.202929975106),
        1.0: (-1.741823228420, -0.966187601349),
    }.items():
        k = np.abs(path.t - t).argmin()
        assert abs(path.t[k] - t) < 1e-9
        np.testing.assert_allclose(path.position(rod.end)[k], tip, rtol=0, atol=5e-5)
    np.testing.assert_allclose(path.position(rod.start), 0.0, rtol=0, atol=1e-12)


def test_the_planned_run_is_as_exact_as_it_is_asked_to_be():
    names = run(FIRST, block_with("ancf.plan"))
    rod = names["rod"]
    scene = ancf.Scene(gravity=(0.0, -9.81))
    fine = scene.add_beam("thin", (0, 0), (2, 0), 60, rod.section, rod.material)
    scene.pin(fine.start)
    exact = ancf.simulate(scene, 2.0, accuracy=1e-5).position(fine.end)
    np.testing.assert_allclose(names["planned"][-1], exact[-1], rtol=0, atol=1e-3)


def test_copies_of_the_scene_are_what_the_page_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = run(FIRST, block_with("refined"))
    scene = names["scene"]
    assert names["fine"].beams[0].n_elements == 20
    assert names["stiff"].beams[0].material.youngs_modulus == 2e8
    assert ancf.Scene.load("pendulum.json") == scene
    k = np.abs(names["run"].t - 0.5).argmin()
    gap = names["tip"][k] - names["run"].position(names["rod"].end)[k]
    assert 1e-5 < np.linalg.norm(gap) < 1e-3  # 2.1e-4 m: two meshes of one pendulum


def test_the_short_tasks_run_as_they_stand(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = run("import ancfsparse as ancf\n", block_with("add_frame"))
    rest, rope = names["rest"], names["rope"]
    assert rest.stable
    # A catenary of 1.2 m over 1 m sags by 0.29234 m; bending makes it a little more pointed.
    np.testing.assert_allclose(rest.position(rope.at(0.6)), (0.5, 0.0, -0.29234), atol=4e-3)
    assert (tmp_path / "rope.gif").stat().st_size > 10_000


def test_loads_run_as_they_stand_and_deflect_the_beam_by_the_static_amount():
    setting = block_with("add_frame").splitlines(keepends=True)[0]
    names = run("import ancfsparse as ancf\n", setting, block_with("point_moment"))
    boom, section, material = (names[name] for name in ("boom", "section", "material"))
    weight = 9.81 * material.density * section.area
    # A clamped beam of 1 m about which it swings: linear theory, and means of what changes.
    deflection = 0.5 / 3 + (weight + 0.15) / 8 - 0.3**2 * (3 - 0.3) / 6 - 0.075 / 2
    motion = ancf.simulate(names["loaded"], t_end=1.0, dt=1e-3)
    np.testing.assert_allclose(
        motion.position(boom.end)[:, 1].mean(),
        -deflection / (material.youngs_modulus * section.inertia_z),
        rtol=0.1,
    )


def test_comments_name_optional_packages_as_the_script_reads_them():
    assert all(comment in README.read_text(encoding="utf-8") for comment in OPTIONAL)
