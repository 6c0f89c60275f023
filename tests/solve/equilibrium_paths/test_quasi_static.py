"""Sequences of equilibria: beside statics, beside motions, and where equilibria are lost."""

import numpy as np
import pytest

import ancfsparse as ancf
from tests.beams import build_beam
from tests.solve.equilibrium_paths.elastica import elastica

SECTION = ancf.Rectangle(0.01, 0.01)
MATERIAL = ancf.Material(youngs_modulus=2e9, density=1000.0)
RISING = ancf.Ramp((0.0, -1.0), 1.0)


def cantilever(load, damping=0.0):
    """A beam of 1 m whose lowest frequency is 2.3 Hz."""
    scene = ancf.Scene(gravity=(0.0, 0.0))
    material = ancf.Material(2e9, 1000.0, rayleigh=(damping, 0.0))
    beam = scene.add_beam("thin", (0, 0), (1, 0), 6, SECTION, material)
    scene.clamp(beam.start)
    scene.point_force(beam.end, load)
    return scene, beam


def test_states_are_equilibria():
    scene, beam = cantilever(lambda t: (-3.0 * t, 4.0 * np.sin(3.0 * t)))
    run = ancf.quasi_static(scene, 1.0, 0.05)
    for k in (0, 7, 20):
        rest = ancf.solve_static(scene, t=run.t[k])
        np.testing.assert_allclose(run.position(beam.end)[k], rest.position(beam.end), atol=1e-9)
        np.testing.assert_allclose(
            run.reaction(beam.start)[k], rest.reaction(beam.start), atol=1e-6
        )
    assert run.stats.recoveries == 0
    assert run.finished


@pytest.mark.parametrize("slow", [4.0, 8.0, 16.0])
def test_what_inertia_changes_is_the_square_of_the_frequency_ratio(slow):
    """Tip force in phase with the tip, 0.1 % of large motion: 1 / (1 - r^2) of its deflection.

    Of that the lowest mode has 97 %, which is the constant.
    """
    frequency = ancf.modes(cantilever((0.0, 0.0))[0], 1).frequencies[0]
    omega = 2.0 * np.pi * frequency / slow
    # Starts at rest in the middle of an equilibrium: all of it vibrates with the load.
    scene, beam = cantilever(lambda t: (0.0, 1e-3 * (1.0 - np.cos(omega * t))), damping=3.0)
    t_end = 5.0 * 2.0 * np.pi / omega
    dt = t_end / 4000
    motion = ancf.simulate(scene, t_end, dt, save_every=10)
    still = ancf.quasi_static(scene, t_end, 10 * dt)
    last = slice(-80, None)
    off = motion.position(beam.end)[last, 1] - still.position(beam.end)[last, 1]
    size = 0.5 * np.ptp(still.position(beam.end)[:, 1])
    # The part in phase; what damping adds is across it.
    wave = -np.cos(omega * still.t[last])
    share = (off @ wave) / (wave @ wave) / size
    assert share * slow**2 == pytest.approx(0.97, rel=0.1)


def test_a_pendulum_follows_slowly_turning_gravity():
    scene, rod = build_beam("thin", (0, 0), (0, -1), 4, SECTION, MATERIAL, "pin")
    scene.changing_gravity(lambda t: (9.81 * t, 0.0))
    run = ancf.quasi_static(scene, 1.0, 0.1)
    x, y = run.position(rod.end).T
    np.testing.assert_allclose(np.arctan2(x, -y), np.arctan(run.t), atol=1e-6)


def test_drives_lead_the_way():
    scene = ancf.Scene(gravity=(0.0, -9.81))
    cord = scene.add_beam("string", (0, 0), (1, 0), 8, ancf.Circle(0.01),
                          ancf.Material(1e7, 1000.0), length=1.2, slack=1e-4)  # fmt: skip
    scene.pin(cord.start)
    scene.drive(cord.end, lambda t: (1.0 + 0.22 * t, 0.0))
    run = ancf.quasi_static(scene, 1.0, 0.02)
    np.testing.assert_allclose(run.position(cord.end)[:, 0], 1.0 + 0.22 * run.t, atol=1e-14)
    rest = ancf.solve_static(scene, t=0.8)
    np.testing.assert_allclose(
        run.position(cord.node(4))[40], rest.position(cord.node(4)), atol=1e-8
    )


def toggle(load=RISING):
    """Two bars whose apex is pushed down: it snaps through at 2 E A sin^3 a / 3 sqrt 3 or so."""
    given = ("string", (0, 0), (1, 0.1), 1, SECTION, ancf.Material(1e7, 1000.0))
    scene, left = build_beam(*given, gravity=(0.0, 0.0))
    right = scene.add_beam(given[0], (1, 0.1), (2, 0), *given[3:])
    scene.connect(left.end, right.start)
    scene.pin(left.start)
    scene.pin(right.end)
    scene.point_force(left.end, load)
    return scene, left.end


def test_a_toggle_snaps_through_and_goes_on_from_there():
    scene, apex = toggle()
    run = ancf.quasi_static(scene, 1.0, 0.02)
    height = run.position(apex)[:, 1]
    assert height[0] == pytest.approx(0.1)
    assert height[-1] < -0.1
    assert run.stats.recoveries == 1
    # Limit load of two bars of rest length l at slope a, from the force along the path.
    y = np.linspace(0.02, 0.1, 20001)
    length, stretched = np.hypot(1.0, 0.1), np.hypot(1.0, y)
    limit = np.max(2.0 * 1e7 * 1e-4 * (1.0 - stretched / length) * y / stretched)
    k = int(np.argmax(height < 0.0))
    assert run.t[k - 1] <= limit <= run.t[k]


@pytest.mark.filterwarnings("ignore::ancfsparse.UnresolvedSignalWarning")
@pytest.mark.parametrize(
    "push",
    [
        ancf.Pulse((0.0, -1.0), 0.301, 0.305),
        ancf.Table([0.0, 0.301, 0.303, 0.305, 1.0], [(0, 0), (0, 0), (0, -1), (0, 0), (0, 0)]),
        ancf.Ramp((0.0, -1.0), 0.303, 0.301) - ancf.Ramp((0.0, -1.0), 0.305, 0.303),
    ],
)
def test_a_push_between_saved_states_makes_it_snap_through(push):
    scene, apex = toggle(push)
    height = ancf.quasi_static(scene, 1.0, 0.02).position(apex)[:, 1]
    np.testing.assert_allclose(height[:16], 0.1)
    np.testing.assert_allclose(height[16:], -0.1)


def test_errors_on_the_way_have_what_was_found():
    def load(t):
        if t > 0.5:
            raise ValueError("no data")
        return 0.0, t

    with pytest.raises(ancf.LoadError, match="no data") as failure:
        ancf.quasi_static(cantilever(load)[0], 1.0, 0.1)
    np.testing.assert_allclose(failure.value.trajectory.t, np.arange(6) / 10)
    assert not failure.value.trajectory.finished


def test_it_begins_where_an_equilibrium_is():
    scene, beam = cantilever(ancf.Ramp((0.0, 1.0), 1.0))
    begin = ancf.solve_static(scene, t=0.5)
    run = ancf.quasi_static(scene, 1.0, 0.25, start=begin)
    np.testing.assert_allclose(run.t, (0.5, 0.75, 1.0))
    np.testing.assert_allclose(run.position(beam.end)[0], begin.position(beam.end), atol=1e-9)
    assert len(ancf.quasi_static(scene, 1.0).t) == 201


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"dt": 0.3}, "does not divide"),
        ({"t_end": -1.0}, "t_end must be positive"),
        ({"tolerance": 1.0}, "from 1e-14 to 0.001, got 1"),
        ({"start": 3}, "start must be a state"),
        ({"factorization": "best"}, "unknown factorization 'best'"),
        ({"scene": 1}, "a Scene is needed, got 1"),
    ],
)
def test_what_is_invalid_is_refused(change, words):
    scene, _ = cantilever((0.0, 1.0))
    with pytest.raises(ancf.InputError, match=words):
        ancf.quasi_static(**({"scene": scene, "t_end": 1.0} | change))


def test_a_straight_column_buckles_when_its_load_passes_eulers():
    """It is still an equilibrium, but no longer a stable one."""
    euler = np.pi**2 / 4.0 * 2e9 * 0.01**4 / 12.0
    scene, beam = cantilever(lambda t: (-1.2 * euler * t, 0.0))
    run = ancf.quasi_static(scene, 1.0, 0.05)
    aside = np.abs(run.position(beam.end)[:, 1])
    assert aside[run.t < 0.8].max() < 1e-6
    for k in (-3, -2, -1):
        assert aside[k] == pytest.approx(elastica(1.2 * run.t[k])[1], rel=0.01)
    assert run.stats.recoveries == 1


def test_what_is_held_stays_where_it_is_over_many_states():
    """Extrapolation let the rounding of pins grow with the cube of the number of states."""
    made = ancf.Circle(0.02), ancf.Material(1e7, 1000)
    scene, left = build_beam("thin", (0, 0), (1, 0.1), 4, *made, gravity=(0.0, 0.0))
    right = scene.add_beam("thin", (1, 0.1), (2, 0), 4, *made)
    scene.pin(left.start)
    scene.drive(right.end, lambda t: (2.0 + 0.02 * np.sin(np.pi * t) * (t < 1.0), 0.0))
    scene.connect(left.end, right.start)
    scene.point_force(left.end, ancf.Ramp((0.0, -3.0), 2.0))
    run = ancf.quasi_static(scene, 2.0, 2.0 / 256)
    assert np.abs(run.position(left.start)).max() == 0.0
    late = run.t >= 1.0
    assert np.abs(run.position(right.end)[late] - (2.0, 0.0)).max() <= 1e-15


def test_more_equilibria_than_fit_in_memory_are_refused_before_the_first():
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.01), ancf.Material(1e8, 1000))
    scene.clamp(rod.start)
    with pytest.raises(ancf.InputError, match=r"the equilibria would need .* GB.* a larger dt"):
        ancf.quasi_static(scene, 1e9, 1e-3)
