"""Strings that go slack: lines and nets that transmit no compression."""

import pickle

import numpy as np
import pytest

import ancfsparse as ancf
from tests.beams import build_beam
from tests.grids import grid
from tests.solve.beams.cords import CORD, RUBBER, STIFFNESS, elastic_catenary

LENGTH = 1.3


def smooth(t, end):
    """From 0 to 1 in the time `end` without a jump of the acceleration."""
    x = min(max(t / end, 0.0), 1.0)
    return x**3 * (10.0 - 15.0 * x + 6.0 * x * x)


def line(n, slack, damping=0.0):
    """A line of 1.3 m between supports 1 m apart, one of which moves away until it is taut."""
    scene = ancf.Scene(gravity=(0.0, -9.81))
    material = ancf.Material(1e7, 1000.0, rayleigh=(damping, 0.0))
    cord = scene.add_beam("string", (0, 0), (1, 0), n, CORD, material, length=LENGTH, slack=slack)
    scene.pin(cord.start)
    scene.drive(cord.end, lambda t: (1.0 + 0.32 * smooth(t, 1.0), 0.0))
    return scene, cord


@pytest.mark.parametrize("t", [0.0, 0.4, 0.7, 1.0])
def test_a_slack_line_that_is_tightened_is_an_elastic_catenary(t):
    """From 1 m, far below its length, to 1.32 m, above it; error of the mesh of second order."""
    span = 1.0 + 0.32 * smooth(t, 1.0)
    sag, force = elastic_catenary(LENGTH, span)
    errors = []
    for n in (16, 32):
        scene, cord = line(n, 1e-4)
        rest = ancf.solve_static(scene, t=t)
        errors.append((-rest.position(cord.node(n // 2))[1] / sag - 1.0,
                       rest.section_force(cord).force[:, 0].mean() / force - 1.0))  # fmt: skip
        assert (rest.section_force(cord).N > 0.0).all()
    fine = np.abs(errors[1])
    assert fine.max() < 2e-3
    # Strains near the transition leave a second part: the larger, the smaller the force.
    np.testing.assert_allclose(np.abs(errors[0]), 4.0 * fine, rtol=0.1, atol=1e-5)


def test_a_transition_below_the_working_strain_moves_a_line_by_less_than_itself():
    """Strains of 7e-4 to 9e-4: with w below them the sag is off by w^4 at first, then by w^2."""
    places = {}
    for slack in (3e-3, 1e-3, 3e-4, 1e-4, 1e-6):
        scene, cord = line(16, slack)
        places[slack] = ancf.solve_static(scene, t=0.5).position(cord.node(8))[1]
    off = {slack: abs(place - places[1e-6]) for slack, place in places.items()}
    assert off[3e-3] < 3e-3
    assert off[1e-3] < 1e-4
    assert off[3e-4] < off[1e-3] / 40.0
    assert off[1e-4] < off[3e-4] / 40.0


def test_a_line_that_is_tightened_in_motion():
    """Settled by damping of its masses, it ends where statics has it."""
    scene, cord = line(12, 1e-4, damping=20.0)
    run = ancf.simulate(scene, 1.5, dt=2e-3, start=ancf.solve_static(scene))
    force = run.section_force(cord).N
    assert force.min() > 0.2  # it was hanging and never slack
    rest = ancf.solve_static(scene, t=1.5)
    taut = rest.section_force(cord).N.mean()
    assert force[-100:].mean() == pytest.approx(taut, rel=0.02)


def test_a_line_let_go_is_slack_and_falls():
    """A taut cord whose end comes back by 0.3 m in 20 ms: nothing pushes it."""
    scene, cord = build_beam("string", (0, 0), (1, 0), 10, CORD, RUBBER, "pin", slack=1e-3)
    scene.drive(cord.end, lambda t: (1.05 - 0.35 * smooth(t - 0.1, 0.02), 0.0))
    rest = ancf.solve_static(scene)
    assert rest.section_force(cord).N.mean() == pytest.approx(0.05 * STIFFNESS, rel=0.01)
    # In steps of 0.2 ms rounding decides whether the motion gains 1 % of energy.
    run = ancf.simulate(scene, 0.3, 1e-4, integrator=ancf.GeneralizedAlpha(0.8), start=rest)
    force = run.section_force(cord).N
    assert force.min() >= 0.0
    assert force.min(axis=0).max() < 1e-6 * STIFFNESS  # each element has been slack


def test_energy_momentum_keeps_the_energy_of_a_line_that_goes_slack_and_taut():
    scene = ancf.Scene(gravity=(0.0, 0.0, -9.81))

    def inward(x):
        return np.stack([-2.0 * x[:, 0], x[:, 0], 0.0 * x[:, 0]], axis=1)

    cord = scene.add_beam(
        "string", (0, 0, 0), (1, 0, 0), 8, CORD, RUBBER, slack=1e-2, velocity=inward
    )
    scene.pin(cord.start)
    run = ancf.simulate(scene, 0.5, dt=5e-4, integrator=ancf.EnergyMomentum(), tolerance=1e-9)
    force = run.section_force(cord).N
    assert force.min() < 1e-5 * STIFFNESS
    assert force.max() > 0.01 * STIFFNESS
    assert np.ptp(run.energy.total) < 1e-9 * np.ptp(run.energy.kinetic)


def test_a_net_pushed_together_carries_nothing():
    """A square of strings, one side of which moves in by 2 %: linear ones push back."""
    nodes, edges, number = grid(4)
    nodes /= 3.0
    forces = []
    for slack in (None, 1e-5):
        scene = ancf.Scene(gravity=(0.0, 0.0))
        net = scene.add_mesh(nodes, edges, "string", CORD, RUBBER, slack=slack)
        for k in number[0]:
            scene.pin(net.node(int(k)))
        for k in number[-1]:
            place = nodes[k]
            scene.drive(net.node(int(k)), lambda t, p=place: p - (0.02 * smooth(t, 1.0), 0.0))
        run = ancf.simulate(scene, 1.0, dt=5e-3, integrator=ancf.GeneralizedAlpha(0.5))
        forces.append(-run.section_force(net).N[-1].min())
    # The linear net buckles at its nodes, so it carries less than 2 % of E A.
    assert forces[0] > 1e-4 * STIFFNESS
    assert forces[1] <= 1e-12 * STIFFNESS


def test_its_element_is_that_of_its_transition_strain():
    scene, cord = line(6, 1e-3)
    assert cord.kind.values == {"transition": 1e-3}
    assert pickle.loads(pickle.dumps(cord.kind)) == cord.kind
    digests = {line(6, slack)[1].describe()["element"] for slack in (1e-3, 1e-4)}
    assert len(digests) == 2
    assert scene.refined(2).bodies[0].kind == cord.kind


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"element": "thin"}, "slack of beam 0 applies to strings only, not to 'thin'"),
        ({"slack": 0.0}, "slack of beam 0 must be positive"),
        ({"slack": 1.5}, "a strain from 1e-09 to 1, got 1.5"),
        ({"slack": 1e-12}, "a strain from 1e-09 to 1, got 1e-12"),
        ({"slack": "soft"}, "slack of beam 0 must be a number, got 'soft'"),
        ({"slack": 1e-3, "tension": 3.0}, "give the length instead"),
    ],
)
def test_what_is_no_slack_string_is_refused(change, words):
    scene = ancf.Scene(gravity=(0.0, -9.81))
    given = {"element": "string", "slack": 1e-3} | change
    with pytest.raises(ancf.InputError, match=words):
        scene.add_beam(
            given.pop("element"), (0, 0), (1, 0), 4, section=CORD, material=RUBBER, **given
        )
