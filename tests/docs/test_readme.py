"""The examples of README.md run as they stand, to the numbers that the equations give."""

import re

import numpy as np
import pytest

import ancfsparse as ancf
from tests.paths import ROOT
from tools.run_readme import OPTIONAL, run_command

README = ROOT / "README.md"
PAGE = README.read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
IMPORT = "import ancfsparse as ancf\n"
MAX_LINES = 4  # of a first step, without imports and the scene that is there


def run(*sources):
    """Run examples of the page one after the other; return their names."""
    names = {}
    exec(compile("".join(sources), "README.md", "exec"), names)
    return names


def block_with(word):
    """Return the example that contains a word."""
    (found,) = (block for block in BLOCKS if word in block)
    return found


PENDULUM = IMPORT + block_with("davidon")


@pytest.mark.parametrize("method", ["run", "paper"])
def test_the_pendulum_reaches_the_reference_positions(method):
    names = run(PENDULUM)
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
    names = run(PENDULUM, block_with("ancf.plan"))
    rod = names["rod"]
    scene = ancf.Scene(gravity=(0.0, -9.81))
    fine = scene.add_beam("thin", (0, 0), (2, 0), 60, rod.section, rod.material)
    scene.pin(fine.start)
    exact = ancf.simulate(scene, 2.0, accuracy=1e-5).position(fine.end)
    np.testing.assert_allclose(names["planned"][-1], exact[-1], rtol=0, atol=1e-3)


def test_copies_of_the_scene_are_what_the_page_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = run(PENDULUM, block_with("refined"))
    scene = names["pendulum"]
    assert names["fine"].beams[0].n_elements == 20
    assert names["stiff"].beams[0].material.youngs_modulus == 2e8
    assert ancf.Scene.load("pendulum.toml") == scene
    k = np.abs(names["run"].t - 0.5).argmin()
    gap = names["tip"][k] - names["run"].position(names["rod"].end)[k]
    assert 1e-5 < np.linalg.norm(gap) < 1e-3  # 2.1e-4 m: two meshes of one pendulum


def test_a_hanging_cable_its_film_and_its_files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    first, second = block_with("rope.png"), block_with("rope.gif")
    for block in first, second:
        lines = [line for line in block.splitlines() if line and not line.startswith("import")]
        assert len(lines) <= MAX_LINES + 1  # of the second three are tasks of their own
    names = run(first, second)
    rope, motion = names["rope"], names["run"]
    # A catenary of 1.2 m over 1 m sags by 0.29234 m; bending makes it a little more pointed.
    np.testing.assert_allclose(motion.position(rope.at(0.6))[0], (0.5, 0.0, -0.29234), atol=4e-3)
    assert np.ptp(motion.position(rope.at(0.6))[:, 1]) > 0.1  # the gusts move it to both sides
    for name, least in (("png", 1e4), ("gif", 5e4), ("html", 5e5), ("vtkhdf", 1e6)):
        assert (tmp_path / f"rope.{name}").stat().st_size > least


def test_the_controller_lifts_the_load_by_the_winch(capsys):
    building, loop = block_with("lift.winch").split("\n\n")
    assert len(loop.splitlines()) <= MAX_LINES + 2  # with the head of the loop and the output
    names = run(IMPORT, building, "\n", loop)
    height, force = map(float, capsys.readouterr().out.split())
    assert height == pytest.approx(-1.5, abs=0.02)
    assert force == pytest.approx(5.0 * 9.81, rel=1e-3)
    assert names["sim"].t == pytest.approx(5.0)


def test_commands_on_files_run_as_they_stand(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    for line in re.findall(r"^ancfsparse (?!demo).*", PAGE, re.MULTILINE):
        run_command(line)
    out, err = capfd.readouterr()
    commands = [
        " ".join(line.split()[1:4]) for line in out.splitlines() if " s: ancfsparse" in line
    ]
    assert len(commands) == 6, err
    one, other, long = (ancf.load(f"{name}.h5") for name in ("cable", "longer", "long"))
    assert (one.system.scene.beams[0].length, other.system.scene.beams[0].length) == (1.2, 1.3)
    assert long.t[-1] == pytest.approx(100.0)
    assert not list(tmp_path.glob("*.checkpoint"))


def test_frames_and_loads_run_as_they_stand():
    names = run(
        block_with("rope.png").replace('.plot().figure.savefig("rope.png")', ""),
        block_with("point_moment"),
    )
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
    assert all(comment in PAGE for comment in OPTIONAL)
