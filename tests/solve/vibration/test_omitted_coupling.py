"""Forces that couple points and are not `coupled`: refused where only the stiffness counts."""

import itertools
import warnings

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import ApproximateModesWarning, EquilibriumError, InputError

SOFT = ancf.Material(1e7, 1000.0)


def two_sliders(function, coupled, load=0.0):
    """Two bodies of 1 kg on springs of 100 N/m along x, and a force on both."""
    scene = ancf.Scene(gravity=(0, 0))
    bodies = [scene.add_body(position=(x, 0), mass=1.0, inertia=1.0) for x in (0.0, 1.0)]
    for body, wall in zip(bodies, (-5.0, 6.0), strict=True):
        scene.prismatic(body.origin, axis=(1, 0))
        scene.spring(body.origin, (wall, 0.0), stiffness=100.0)
    scene.force([body.origin for body in bodies], function, coupled=coupled)
    scene.point_force(bodies[0].origin, (load, 0.0))
    return scene


def pull(q, v, t):
    """A spring of 400 N/m between the first point and the last."""
    out = np.zeros_like(q)
    out[0, 0] = 400.0 * (q[-1, 0] - q[0, 0] - 1.0)
    out[-1] = -out[0]
    return out


def damp(q, v, t):
    """A dashpot from the last point to the first, which acts on the first alone."""
    out = np.zeros_like(q)
    out[0, 0] = 3.0 * v[-1, 0]
    return out


@pytest.mark.parametrize("find", [ancf.modes, ancf.complex_modes])
@pytest.mark.parametrize("function", [pull, damp])
@pytest.mark.filterwarnings("ignore::ancfsparse.errors.ApproximateModesWarning")
def test_a_force_that_couples_points_is_refused_if_it_is_not_coupled(find, function):
    for of in (lambda scene: scene, ancf.solve_static):
        with pytest.raises(InputError, match=r"alone move, by up to .* give coupled=True"):
            find(of(two_sliders(function, coupled=False)), 2)
    found = find(two_sliders(function, coupled=True), 2)
    if function is pull:
        expected = np.sqrt([100.0, 900.0]) / (2.0 * np.pi)
        np.testing.assert_allclose(found.frequencies, expected, rtol=1e-8)


@pytest.mark.parametrize("n_elements", [1, 7])
@pytest.mark.parametrize("k", [2, 3, 5])
@pytest.mark.filterwarnings("ignore::ancfsparse.errors.ApproximateModesWarning")
def test_any_two_points_that_a_force_couples_are_found(k, n_elements):
    def held(one, other):
        def law(q, v, t):
            mean = q.mean(axis=0)  # whose rounding is no coupling
            out = -30.0 * ((q - mean) + mean - places)
            out[one] += 1e-3 * (q[other] - places[other])
            return out

        scene = ancf.Scene(gravity=(0, 0))
        rod = scene.add_beam("thin", (10, 0), (11, 0), n_elements, ancf.Circle(0.01), SOFT)
        scene.clamp(rod.start)
        points = [rod.at((j + 1) / k) for j in range(k)]
        places = np.array([point.position for point in points])
        scene.force(points, law)
        return scene

    assert ancf.complex_modes(held(0, 0), 1).stable
    for one, other in itertools.permutations(range(k), 2):
        with pytest.raises(InputError, match="is not coupled"):
            ancf.complex_modes(held(one, other), 1)


@pytest.mark.parametrize("place", [0.0, 100.0, 1000.0])
@pytest.mark.filterwarnings("ignore::ancfsparse.errors.ApproximateModesWarning")
def test_rounding_far_from_the_origin_is_no_coupling(place):
    scene = ancf.Scene(gravity=(0, 0))
    rod = scene.add_beam("thin", (place, 0), (place + 0.1, 0), 20, ancf.Circle(0.01), SOFT)
    scene.clamp(rod.start)
    points = [rod.at(0.02 * (j + 1)) for j in range(5)]
    places = np.array([point.position for point in points])
    scene.force(points, lambda q, v, t: -30.0 * ((q - q.sum(axis=0)) + q.sum(axis=0) - places))
    ancf.complex_modes(scene, 1)


def whirl(q, v, t):
    """Forces across the velocities, as gyroscopes exert."""
    return 3.0 * np.stack([v[::-1, 0] * [1.0, -1.0], 0.0 * v[:, 0]], axis=1)


def follow(q, v, t):
    """A force on the first point by the displacement of the last."""
    return np.array([[20.0 * (q[-1, 0] - 1.0), 0.0], [0.0, 0.0]])


@pytest.mark.parametrize(("function", "warns"), [(pull, False), (whirl, True), (follow, True)])
def test_modes_warn_of_unsymmetric_matrices_alone(function, warns):
    scene = two_sliders(function, coupled=True)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        ancf.modes(scene, 2)
    assert [each.category for each in caught] == [ApproximateModesWarning] * warns


def test_statics_that_fail_for_omitted_coupling_say_so():
    with pytest.raises(EquilibriumError, match=r"is not coupled, but at .* give coupled=True"):
        ancf.solve_static(two_sliders(pull, coupled=False, load=50.0))


def explicit_step(scene):
    return ancf.stable_step(scene, ancf.DormandPrince())


@pytest.mark.parametrize("find", [ancf.buckling, ancf.load_path, explicit_step])
@pytest.mark.filterwarnings("ignore::ancfsparse.errors.ApproximateModesWarning")
def test_what_only_the_stiffness_determines_is_refused(find):
    with pytest.raises(InputError, match=r"alone move, by up to .* give coupled=True"):
        find(two_sliders(pull, coupled=False, load=50.0))
    find(two_sliders(pull, coupled=True, load=50.0))
