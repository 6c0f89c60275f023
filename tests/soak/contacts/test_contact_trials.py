"""Trials of contacts find what they judge, and draw what they claim."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree

import ancfsparse as ancf
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.force_elements import contact_points
from ancfsparse.system import System
from ancfsparse.system.contributions.force_elements.contact import axis_depths, contacts
from tests.soak.contacts import trials
from tests.soak.contacts.parts import recorded_parts, with_parts
from tests.soak.contacts.scenes import LAYOUTS, Touching, draw
from tests.soak.contacts.sides import passes_base, passes_between
from tests.soak.scenes import draw_integrator, draw_solver

CONSERVING = ancf.EnergyMomentum()


def scene_of(choose):
    """Return the first scene with a property."""
    drawings = (draw(np.random.default_rng([3, index])) for index in range(500))
    return next(drawn for drawn in drawings if choose(drawn))


def lies_on(drawn, noun, friction=False):
    contact = drawn.contacts[0]
    return (
        isinstance(contact, trials.Contact)
        and contact.obstacle.noun == noun
        and bool(contact.friction) == friction
        and not drawn.is_explicit
    )


def is_turned(drawn):
    return lies_on(drawn, "drum", True) and drawn.contacts[0].obstacle.spin.any()


def test_all_parts_are_drawn():
    drawings = [draw(np.random.default_rng([3, index])) for index in range(120)]
    assert {drawn.words["layout"] for drawn in drawings} == {*LAYOUTS}
    nouns = {
        contact.obstacle.noun
        for drawn in drawings
        for contact in drawn.contacts
        if isinstance(contact, trials.Contact)
    }
    assert nouns == {"half-space", "ball", "drum"}
    assert {drawn.is_explicit for drawn in drawings} == {True, False}
    rubbing = [(each, drawn) for drawn in drawings for each in drawn.contacts
               if isinstance(each, trials.Contact) and each.friction]  # fmt: skip
    assert 0.3 < np.mean([each.sticks for each, _ in rubbing]) < 0.7
    assert not any(each.sticks and drawn.is_explicit for each, drawn in rubbing)
    assert any(drawn.is_explicit for _, drawn in rubbing)
    assert not any(each.restitution for each, _ in rubbing)
    lengths = [drawn.words["length"] for drawn in drawings]
    assert min(lengths) < 3e-3
    assert max(lengths) > 30.0


@pytest.mark.parametrize("kind", [trials.Contact, trials.BeamContact])
def test_restitution_and_static_friction_are_drawn_without_changing_the_rest(kind):
    streams = ([np.random.default_rng([3, index, k]) for k in range(2)] for index in range(120))
    drawings = [draw(*pair) for pair in streams]
    contacts = [each for drawn in drawings for each in drawn.contacts if isinstance(each, kind)]
    assert 0.05 < np.mean([each.restitution > 0.0 for each in contacts]) < 0.5
    assert any(each.has_static_friction for each in contacts)
    plain = draw(np.random.default_rng([3, 0, 0]))
    assert (
        plain.words.items() <= {**drawings[0].words, "dt": plain.dt, "steps": plain.steps}.items()
    )


def test_random_contacts_are_judged_without_a_find():
    reports = [trials.run(3, index) for index in range(20)]
    assert [find for report in reports for find in report.finds] == []
    assert sum(report.outcome == "finished" for report in reports) > 10


@pytest.mark.parametrize(("seed", "index"), [(30301, 18), (30302, 3)])
def test_bent_ropes_of_a_given_radius_begin_apart(seed, index):
    # The bar was drawn thinner than the radius that its contact gave it: the ropes began inside it.
    drawn = draw(np.random.default_rng([seed, index]), layout="bend")
    system = System(drawn.scene)
    (part,) = (each for each in system.contributions if hasattr(each, "contact"))
    depth, radius, *_ = part.deepest_at(system.q0)
    assert depth <= 1e-3 * radius


def test_penetrations_of_solutions_that_are_not_taken_are_no_warning():
    # The run warned of a penetration by the radius, that of a solution which gave way to another.
    report = trials.run_bend(30603, 3)
    assert report.outcome == "finished"
    assert report.finds == []


def test_parts_of_a_discarded_repetition_are_not_judged():
    # Steps that Newton's method repeated in vain were taken for those of the run: ropes crossed.
    report = trials.run_bend(93002, 8)
    assert report.outcome == "failed (EnergyIncreaseError)"
    assert report.finds == []


def test_ropes_that_are_bent_around_bars_are_judged_without_a_find():
    reports = [trials.run_bend(1, index) for index in (4, 7, 9, 11, 17)]
    assert [find for report in reports for find in report.finds] == []
    assert [report.outcome for report in reports] == 5 * ["finished"]


@pytest.mark.parametrize(
    ("seed", "index"),
    [
        # Friction that pushed along the sliding in unresolved steps counted as supplied energy.
        *((7703, 59), (9102, 521)),
        # Newton solves steps before the failed one otherwise: from these states no step led on.
        *((11001, 2122), (13001, 23), (13001, 599), (13001, 2234), (13001, 2454), (14003, 352)),
        # The end of a cable whips on a drum of a given stiffness; the run warns that it sinks in.
        (15001, 2339),
        # The work of a force in the parts of a step was not counted.
        (9401, 216),
        # Damped Newton converges from the first predictor alone; descent led far away.
        (9301, 254),
        # Bent ropes that slide on each other seemed to pass through, by chords of quarter elements.
        (11001, 1713),
        # The stiffness that was drawn was too soft for a cable that springs back from its arc.
        (11001, 1839),
        # The end of a cable was inside a drum, and the points beside it not.
        (30201, 411),
        # A cable with six elements had a bend between two points, which did not touch.
        (30501, 532),
        # A thick beam flew off with 4.5e7 J in the first step, and was stopped in step 16 only.
        (60004, 266),
    ],
)
def test_contacts_that_once_were_found_are_not(seed, index):
    assert trials.run(seed, index, has_laws=False).finds == []


def test_a_contact_that_is_far_too_soft_is_seen(monkeypatch):
    drawn = scene_of(lambda each: lies_on(each, "half-space") and each.words["gravity"])
    for contact in drawn.contacts:
        contact.__dict__["stiffness"] = None
    assert trials.attempt(drawn, CONSERVING, "auto").finds == []
    monkeypatch.setattr(contacts, "default_stiffness", lambda *_: 1e-3)
    finds = trials.attempt(drawn, CONSERVING, "auto").finds
    assert any("radii inside" in find for find in finds)
    assert any("passes through the half-space" in find for find in finds)


@pytest.mark.parametrize("is_divided", [True, False])
def test_an_end_that_sinks_in_without_a_warning_is_seen(is_divided, monkeypatch):
    scene = ancf.Scene((0, -9.81))
    cable = ancf.Circle(0.01), ancf.Material(1e8, 5e3)
    rod = scene.add_beam("thin", (0, 0.03), (1, 0.33), 3, *cable)
    if not is_divided:
        monkeypatch.setattr(contact_points, "MAX_END_RATIO", 1e3)
        monkeypatch.setattr(axis_depths.AxisDepths, "warnings", lambda *_: [])
    contact = scene.contact(rod, ancf.HalfSpace((0, 0), (0, 1)))
    drawn = Touching(scene, [rod], 2e-3, 60, contacts=[contact])
    finds = trials.attempt(drawn, CONSERVING, "auto").finds
    if is_divided:
        assert finds == []
    else:
        assert any("without a warning" in find for find in finds)


def test_friction_above_that_of_coulomb_is_seen(monkeypatch):
    drawn = scene_of(lambda each: is_turned(each) and each.words["layout"] == "wrap")
    path, _ = trials.simulate(drawn, CONSERVING, "auto")
    assert trials.judge(drawn, path) == []
    forces_of_package = ancf.Trajectory.contact_force

    def with_more(self, contact):
        forces = forces_of_package(self, contact)
        return replace(forces, friction=1.1 * forces.friction)

    monkeypatch.setattr(ancf.Trajectory, "contact_force", with_more)
    assert any("friction exceeds mu p" in find for find in trials.judge(drawn, path))


def test_the_work_of_a_force_is_counted_in_all_parts_of_a_step():
    rng = np.random.default_rng([9401, 216])
    drawn, integrator, solver = draw(rng), draw_integrator(rng), draw_solver(rng)
    drawn.dt *= 1.5  # for steps that are divided
    with recorded_parts() as parts:
        path, _ = trials.simulate(drawn, integrator, solver)
    assert path.stats.short_steps == len(parts) > 0
    whole = with_parts(path, parts)
    assert len(whole.t) > len(path.t)
    assert np.isin(path.t, whole.t).all()
    assert (np.diff(whole.t) > 0.9 * drawn.dt / 2**drawn.max_halvings).all()
    # The method conserves energy; no contact has friction.
    size = whole.energy.kinetic.max()
    change = whole.energy.total - whole.energy.total[0]
    assert np.abs(change - trials.given_work(drawn, whole)).max() < 1e-9 * size
    assert np.abs(path.energy.total - path.energy.total[0]
                  - trials.given_work(drawn, path)).max() > 1e-3 * size  # fmt: skip


def test_energy_that_no_force_gave_is_seen():
    drawn = scene_of(lambda each: lies_on(each, "ball"))
    path, again = (trials.simulate(drawn, CONSERVING, "auto")[0] for _ in range(2))
    assert trials.judge(drawn, path) == []
    again.v[-1] *= 1.1
    assert any("more than was given" in find for find in trials.judge(drawn, again))


@pytest.mark.parametrize("slip_speed", [None, 0.1])
def test_the_work_of_a_turning_drum_is_given(monkeypatch, slip_speed):
    scene = ancf.Scene((0, 0))
    arc = ancf.Arc((0, 0), (-0.102, 0), -3.0)
    cable = {"section": ancf.Circle(0.004), "material": ancf.Material(1e8, 1e3)}
    rod = scene.add_beam("thin", curve=arc, n_elements=16, **cable)
    load = ancf.Ramp((0.0, -1.0), 0.005)
    scene.pin(rod.start)
    scene.point_force(rod.end, load)
    drum = ancf.Drum((0, 0), 0.1, angular_velocity=-5.0)
    contact = scene.contact(rod, drum, friction=0.3, slip_speed=slip_speed)
    drawn = Touching(scene, [rod], 5e-4, 60, contacts=[contact], pulls=[(rod.end, load)])
    path, _ = trials.simulate(drawn, CONSERVING, "auto")
    assert trials.judge(drawn, path) == []
    given = trials.given_work(drawn, path)
    assert (given >= path.energy.work - 1e-3 * np.abs(path.energy.work).max()).all()
    monkeypatch.setattr(trials, "surface_power", lambda contact, path: np.zeros(len(path.t)))
    assert (trials.given_work(drawn, path) < given).any()


@pytest.mark.parametrize(
    ("by_newton", "by_solver", "outcome", "is_found"),
    [
        (1.0, 0.0, "failed (ConvergenceError)", True),
        (1.0, 0.7, "failed (ConvergenceError)", True),
        (0.7, 0.1, "failed (ConvergenceError)", True),
        (0.7, 0.7, "failed by chance (ConvergenceError)", False),
    ],
)
def test_a_run_that_newton_finishes_must_not_fail_but_by_chance(
    monkeypatch, by_newton, by_solver, outcome, is_found
):
    drawn = scene_of(lambda each: lies_on(each, "half-space"))
    shares = {"auto": by_solver, ancf.Newton(): by_newton}

    def fail(drawn, integrator, solver, moved=1.0):
        fails = solver == "auto" if moved == 1.0 else next(turn) >= shares[solver]
        if fails:
            raise ancf.ConvergenceError("it did not converge", 0.1, 2, 0.1, 1.0, "a node")

    turn = itertools.cycle(np.arange(8) / 8.0)
    monkeypatch.setattr(trials, "simulate", fail)
    report = trials.attempt(drawn, CONSERVING, "auto")
    assert report.outcome == outcome
    assert any("Newton finishes it" in find for find in report.finds) == is_found


def test_an_error_of_two_lines_is_a_find():
    assert trials.judge_sentence(ValueError("one sentence with its numbers")) == []
    assert "no sentence" in trials.judge_sentence(ValueError("one line\nand another"))[0]


def test_a_pass_to_the_other_side_is_seen():
    floor, ball = ancf.HalfSpace((0, 0), (0, 1)), ancf.Ball((0, 0), 1.0)
    drum = ancf.Drum((0, 0, 0), 1.0, axis=(0, 0, 1))
    above, below = np.array([[0.3, 1.2]]), np.array([[0.3, -1.2]])
    assert passes_base(floor, np.stack([above, above, below])) == 2
    assert passes_base(floor, np.stack([above, above])) is None
    assert passes_base(ball, np.stack([above, below])) == 1
    # Around it, on either side.
    beside = np.array([[1.3, 0.1]])
    assert passes_base(ball, np.stack([above, beside, below])) is None
    along = np.array([[[0.3, 1.2, 0.0]], [[0.2, 1.2, 9.0]], [[0.2, -1.2, 9.0]]])
    assert passes_base(drum, along[:2]) is None
    assert passes_base(drum, along) == 2


def test_curves_that_pass_through_each_other_are_seen():
    x = np.linspace(-1.0, 1.0, 6)
    lower = np.stack([x, 0 * x, 0 * x], axis=1)
    upper = np.stack([0.1 + 0 * x, x, 0.2 + 0 * x], axis=1)
    still = np.stack([lower, lower, lower])
    down = np.array([0.0, 0.0, 0.15])
    assert passes_between(still, np.stack([upper, upper - down, upper - 2 * down])) == 2
    assert passes_between(still, np.stack([upper, upper - down, upper])) is None
    # Beyond its end there is no other curve.
    aside = np.array([1.5, 0.0, 0.0])
    assert passes_between(still, np.stack([upper, upper + aside, upper + aside - 2 * down])) is None


def test_ropes_are_followed_along_their_bent_axes_and_in_all_parts_of_a_step():
    rng = np.random.default_rng([11001, 1713])
    drawn, integrator, solver = draw(rng), draw_integrator(rng), draw_solver(rng)
    contact = drawn.contacts[0]
    drop = 0.1 * drawn.beams[0].lengths.sum() * drawn.scene.gravity / 9.81
    with recorded_parts() as parts:
        path, _ = trials.simulate(drawn, integrator, solver)
    whole = with_parts(path, parts)
    assert trials.judge_contacts(drawn, path, whole) == []
    # Nowhere in the step are axes nearer than nine tenths of two radii, at points that are a
    # thousandth of an element apart: they do not pass through each other.
    k = int(np.searchsorted(whole.t, 0.493))
    fine = [trials.points_along(body, np.linspace(0.0, 1.0, 1001)) for body in contact.bodies]
    for state in whole.q[k - 3 : k + 3]:
        a, b = (trials.positions(whole, points, state[None])[0] for points in fine)
        assert KDTree(a).query(b)[0].min() > 1.8 * min(contact.radii)
    # A rope that passes to the other side and back, in parts of one step, is seen.
    states = whole.q[:].copy()
    for element in range(contact.bodies[1].n_elements):
        for x in (0.0, 1.0):
            where, weights = whole.system.point(Point(contact.bodies[1], element, x))
            begin = states[k, where] @ weights
            states[k, where[:, np.argmax(weights)]] = begin + drop
    finds = trials.judge_contacts(drawn, path, replace(whole, q=states))
    assert any("pass through each other" in find for find in finds)
