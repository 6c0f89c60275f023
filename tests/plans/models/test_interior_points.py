"""Points inside beams where forces, joints and force elements act are nodes of every mesh."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.models.graded_mesh import part_counts
from ancfsparse.plans.models.model import MIN_NODE_DISTANCE, Model, build_model, refine_given_meshes
from ancfsparse.plans.selection.element_hierarchy import CABLE
from ancfsparse.scene.records.record import PointRef
from tests.plans.comparison import build_trials
from tests.plans.interior_points import INSIDE, KINDS, draw, missed, plan_of

MAX_RATIO = 1.2  # of the error to the tolerance, the uncertainty of the reference included


def points(scene):
    """Return all references to points in the records of a scene."""
    found = []

    def note(reference):
        if isinstance(reference, PointRef):
            found.append(reference)
        return reference

    for record in scene.records:
        record.moved(note)
    return found


@pytest.mark.parametrize("inside", INSIDE)
@pytest.mark.parametrize("kind", KINDS)
def test_they_are_nodes_of_every_mesh(kind, inside):
    drawn = draw(np.random.default_rng([1, KINDS.index(kind), INSIDE.index(inside)]), kind, inside)
    for count in (2, 4, 6, 9):
        scene = build_model(drawn.scene, Model({drawn.line.name: CABLE}, {drawn.line.name: count}))
        found = points(scene)
        assert len(found) > 2
        assert not any(reference.xi for reference in found)
        for one, other in zip(points(drawn.scene), found, strict=True):
            place = one.of(drawn.scene).s / drawn.line.length
            beam = scene.body(drawn.line.name)
            assert other.of(scene).s / beam.length == pytest.approx(place, abs=1e-12)


def test_points_that_nearly_coincide_share_a_node():
    scene = ancf.Scene()
    made = ancf.Circle(0.01), ancf.Material(1e9, 1e3)
    line = scene.add_beam("auto", (0, 0), (1, 0), "auto", *made)
    scene.pin(line.start)
    scene.pin(line.end)
    for s in (0.3001, 0.3001 + 0.5 * MIN_NODE_DISTANCE, 0.5 * MIN_NODE_DISTANCE):
        scene.point_force(line.at(s), (0.0, -1.0))
    mesh = build_model(scene, Model({line.name: CABLE}, {line.name: 10})).body(line.name)
    assert mesh.lengths.min() > MIN_NODE_DISTANCE
    assert np.abs(mesh.arcs - 0.3001).min() < 1e-12


@pytest.mark.parametrize("place", [0.26, 0.33, 0.37])
def test_given_meshes_are_compared_with_ones_that_have_nodes_there(place):
    def line(n, nodes=None):
        scene = ancf.Scene((0.0, 0.0))
        made = ancf.Circle(0.002), ancf.Material(5e10, 3000.0)
        cord = scene.add_beam("string", (0, 0), (2, 0), n, *made, tension=800.0, nodes=nodes)
        scene.pin(cord.start)
        scene.pin(cord.end)
        point = cord.at(place * cord.length)
        scene.point_force(point, (0.0, -16.0))
        return scene, point

    scene, point = line(8)
    fine, other = line(3, (0.0, place, 0.9, 1.0))  # exact: both parts are straight
    error = abs((ancf.solve_static(scene).position(point)
                 - ancf.solve_static(fine).position(other))[1])  # fmt: skip
    plan = ancf.plan(scene, quantity=ancf.static_deflection(point), error="3 %")
    assert plan.predictions[0].error == pytest.approx(error, rel=0.4)
    assert plan.predictions[0].error > error
    finer = refine_given_meshes(scene)
    assert not any(reference.xi for reference in points(finer))


@pytest.mark.parametrize(
    ("seed", "kind", "inside"),
    [
        (8, "taut", "force"),
        (3, "taut", "spring"),
        (3, "slack", "mass"),
        (3, "slack", "spring"),
        (4, "slack", "follower"),
    ],
)
def test_equilibria_are_found_to_the_error(seed, kind, inside):
    """Without nodes there the errors were 1.6 to 7.3 times the tolerance."""
    rng = np.random.default_rng([seed, KINDS.index(kind), INSIDE.index(inside)])
    drawn = draw(rng, kind, inside, moving=False)
    plan = plan_of(drawn, 0.01)
    ratio, uncertain = missed(drawn, plan)
    assert plan.is_met
    assert ratio <= MAX_RATIO + uncertain, drawn.words


@pytest.mark.parametrize(
    ("seed", "inside"),
    [(10, "force"), (4, "mass"), (11, "spring"), (7, "follower"), (9, "support")],
)
def test_motions_of_taut_lines_are_found_to_the_error(seed, inside):
    """Without nodes there the errors were 1.3 to 3.4 times the tolerance."""
    drawn = draw(np.random.default_rng([seed, INSIDE.index(inside)]), "taut", inside, moving=True)
    plan = plan_of(drawn, 0.03)
    ratio, uncertain = missed(drawn, plan)
    assert plan.is_met
    assert ratio <= MAX_RATIO + uncertain, drawn.words


def test_coarse_meshes_that_grow_unevenly_are_not_accepted():
    """Of 4, 7 and 10 elements the last, accepted by the ratio of steps, was 2.7 tolerances off."""
    rng = np.random.default_rng([30201, 117])
    rng.choice(2)
    drawn = draw(rng)
    plan = plan_of(drawn, 0.03)
    ratio, uncertain = missed(drawn, plan)
    assert plan.is_met
    assert ratio <= MAX_RATIO + uncertain, drawn.words


@pytest.mark.parametrize("index", [19, 71])
def test_meshes_with_kinks_of_waves_are_not_assumed_to_be_of_high_order(index):
    """Meshes of 7 and 10 elements agreed by chance, and errors were 1.5 and 1.7 tolerances."""
    rng = np.random.default_rng([40003, index])
    rng.choice(2)
    drawn = draw(rng)
    plan = plan_of(drawn, 0.01)
    ratio, uncertain = missed(drawn, plan)
    assert plan.is_met
    assert ratio <= 1.0 + uncertain, drawn.words


@pytest.mark.parametrize("seed", range(5))
def test_successive_meshes_differ_in_every_part(seed):
    """Where two meshes are the same, their difference hides the error there."""
    inner = np.sort(np.random.default_rng(seed).uniform(0.04, 0.96, 3))
    parts = np.diff([0.0, *inner, 1.0])
    counts = np.array([part_counts(n, parts) for n in (8, 12, 18, 27, 41)])
    assert (np.diff(counts, axis=0)[:, parts > 0.04] > 0).all()
    assert (counts.sum(axis=1) <= np.array([8, 12, 18, 27, 41]) + 4 * len(parts)).all()


@pytest.mark.parametrize("parts", [(0.2, 0.5, 0.3), (0.27, 0.73), (0.13, 0.41, 0.46)])
def test_successive_fine_meshes_are_similar(parts):
    """The error depends on the ratios of lengths of adjacent elements, which varied by .1."""
    counts = np.array([part_counts(n, parts) for n in (8, 61, 94, 141, 212)])
    assert (counts / counts[:1] == (counts / counts[:1])[:, :1]).all()


def test_places_of_moments_are_nodes_of_every_mesh():
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (1, 0), "auto", ancf.Circle(0.01), ancf.Material(1e9, 1e3))
    scene.clamp(rod.start)
    for make, count in ((ancf.position, 0), (ancf.section_force, 1), (ancf.strain, 1)):
        trials = build_trials(scene, 1.0, make(rod.at(0.37)), 1e-3)
        for n in (8, 12, 18):
            built = trials.build(trials.with_mesh(Model(), n)).body(rod.name)
            assert np.count_nonzero(np.abs(built.arcs - 0.37) < 1e-12) == count
