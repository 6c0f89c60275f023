"""Films of shaded tubes and surfaces: sizes, what hides what, colours."""

import numpy as np
import pytest
from PIL import Image

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.results.plotting.shaded_scene import BODY_COLOUR

pytestmark = pytest.mark.usefixtures("close_figures")
SOFT = ancf.Material(1e6, 1000.0)


def pictures(run, path, **options):
    """Return the pictures of a film, (frames, height, width, 3)."""
    run.animate(path, style="solid", seconds=0.2, fps=10, progress=False, **options)
    with Image.open(path) as film:
        frames = []
        for k in range(film.n_frames):
            film.seek(k)
            frames.append(np.asarray(film.convert("RGB"), int))
    return np.array(frames)


def is_blue(picture):
    """Tell which pixels show a beam without a quantity."""
    return picture[..., 2] > picture[..., 0] + 60


def bar(*points):
    """Return the run of straight beams of 0.1 m diameter in space, without gravity."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    for start, end in points:
        scene.add_beam("thin", start, end, 4, ancf.Circle(0.1), SOFT)
    return scene


def test_a_tube_has_its_true_size(tmp_path):
    run = ancf.simulate(bar(((0, 0, 0), (1, 0, 0))), 2e-3, 1e-3)
    seen = is_blue(pictures(run, tmp_path / "a.gif", view="xz")[0])
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    assert len(rows) / len(columns) == pytest.approx(0.1, rel=0.1)


@pytest.mark.parametrize(("y", "is_visible"), [(-0.6, True), (0.6, False)])
def test_a_ball_hides_what_is_behind_it_alone(tmp_path, y, is_visible):
    scene = bar(((-0.2, y, 0), (0.2, y, 0)), ((-1, 0, -1), (1, 0, -1)))
    scene.contact(scene.beams[0], ancf.Ball((0.0, 0.0, 0.0), 0.4), stiffness=1.0)
    run = ancf.simulate(scene, 2e-3, 1e-3)
    picture = pictures(run, tmp_path / "a.gif", view=(0.0, -90.0))[0]  # along y
    half = len(picture) // 2  # the other beam is in the lower half
    assert is_blue(picture[half:]).any()
    assert is_blue(picture[:half]).any() == is_visible


def test_colours_follow_the_quantity_and_its_bar(tmp_path):
    scene = ancf.Scene((0.0, 0.0))
    for height, load in ((0.0, 0.0), (1.0, 100.0)):
        beam = scene.add_beam("thin", (0, height), (1, height), 2, ancf.Circle(0.1), SOFT)
        scene.clamp(beam.start)
        scene.point_force(beam.end, (load, 0.0))
    run = ancf.simulate(scene, 2e-2, 1e-2, start=ancf.solve_static(scene))
    picture = pictures(run, tmp_path / "a.gif", colour="N")[0][60:]  # below the title
    rows = np.flatnonzero((picture.max(axis=2) - picture.min(axis=2) > 40).any(axis=1))
    upper, lower = picture[rows[0] : rows[len(rows) // 2 - 1]], picture[rows[len(rows) // 2] :]

    def brightness(part):
        return part[part.max(axis=2) - part.min(axis=2) > 40].mean()

    assert brightness(upper) < brightness(lower) - 30  # dark for the larger force


def test_bodies_and_discs_are_surfaces_on_white(tmp_path):
    scene = ancf.Scene((0.0, -9.81))
    disc = scene.add_body(ancf.Cylinder(0.1, 0.4), density=100.0, position=(0, 0), name="disc")
    scene.pin(disc.origin)
    picture = pictures(ancf.simulate(scene, 0.02, 0.01), tmp_path / "a.gif")[0]
    assert (picture[-1, 0] == 255).all()
    red, green, blue = (int(BODY_COLOUR[k : k + 2], 16) for k in (1, 3, 5))
    # Of one colour with the ratios of its components, and round.
    orange = abs(picture[..., 0] * green - picture[..., 1] * red) < 20 * 255
    orange &= picture[..., 0] - picture[..., 2] > (red - blue) // 2
    rows, columns = (np.flatnonzero(orange.any(axis=axis)) for axis in (1, 0))
    assert len(rows) == pytest.approx(len(columns), abs=3)
    assert orange.sum() / (len(rows) * len(columns)) == pytest.approx(np.pi / 4, abs=0.06)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"style": "tubes"}, "unknown style"),
        ({"colour": "N"}, "colour is for style='solid': give both"),
        ({"style": "solid", "colour": "M"}, "unknown colour"),
        ({"style": "solid", "view": "xq"}, "view must name two of"),
    ],
)
def test_invalid_options_are_refused(tmp_path, options, message):
    run = ancf.simulate(bar(((0, 0, 0), (1, 0, 0))), 2e-3, 1e-3)
    with pytest.raises(InputError, match=message):
        run.animate(tmp_path / "a.gif", **options)
