"""Beams: what they hand on, and what they refuse."""

import numpy as np
import pytest

from ancfsparse.errors import InputError
from ancfsparse.scene import Circle, Material, Point, Rectangle, Scene, Section

SQUARE = Rectangle(0.01, 0.01)
RUBBER = Material(1e8, 4000.0, 0.3)
SPATIAL = (0.0, -9.81, 0.0)


def add(scene=None, **changes):
    given = {"element": "thin", "start": (0, 0), "end": (2, 0), "n_elements": 10,
             "section": SQUARE, "material": RUBBER} | changes  # fmt: skip
    return (scene or Scene()).add_beam(**given)


def test_the_rod_of_the_readme():
    scene = Scene(gravity=(0.0, -9.81))
    rod = add(scene)
    assert scene.beams == [rod]
    assert scene.dim == 2
    np.testing.assert_array_equal(scene.gravity, [0.0, -9.81])
    assert (rod.name, rod.element, rod.n_nodes, rod.length) == ("beam 0", "thin", 11, 2.0)
    assert rod.options == {"strain": "green"}
    assert rod.velocity is None
    np.testing.assert_allclose(rod.positions[:, 0], np.arange(11) * 0.2, atol=1e-15)
    np.testing.assert_array_equal(rod.positions[:, 1], 0.0)
    assert repr(rod) == "beam 0: 10 thin elements, 2 m, planar"
    assert repr(scene) == "planar scene: beams 1, joints 0, loads 0"


def test_beams_are_equal_only_to_themselves():
    assert add() != add()


def test_options_are_those_of_the_element():
    assert add(element="l2t2").options == {}
    assert add(strain="biot").options == {"strain": "biot"}
    plain, given = Scene(), Scene()
    add(plain), add(given, strain="green")
    assert plain == given
    thick = add(element="thick", curvature="section", section_strain="nodal")
    assert thick.options == {"curvature": "section", "section_strain": "nodal"}


def test_parameters_of_the_papers_pendulum():
    # By hand: A = 1e-4 m2, I = 1e-8/12 m4, E = 1e8 Pa, nu = 0.3, rho = 4000 kg/m3, 10 elements.
    # G = 1e8/2.6 = 3.8461538e7 Pa, lam = 2 G 0.3/0.4 = 1.5 G, k = 13/15.3 = 0.8496732 (Cowper),
    # J = 0.1405770 b^4 (Saint-Venant).
    shear_area = 1e8 / 2.6 * 1e-4
    expected = {
        "length": 0.2,
        "axial_stiffness": 1e4,
        "bending_stiffness": 1e8 * 1e-8 / 12,
        "mass_per_length": 0.4,
        "lame_area": 1.5 * shear_area,
        "shear_modulus_area": shear_area,
        "youngs_modulus_area": 1e4,
        "poisson_ratio": 0.3,
        "shear_stiffness_y": 13 / 15.3 * shear_area,
        "shear_stiffness_z": 13 / 15.3 * shear_area,
        "torsion_stiffness": 1e8 / 2.6 * 0.1405770 * 1e-8,
        "bending_stiffness_y": 1e8 * 1e-8 / 12,
        "bending_stiffness_z": 1e8 * 1e-8 / 12,
        "inertia_y": 4000 * 1e-8 / 12,
        "inertia_z": 4000 * 1e-8 / 12,
    }
    parameters = add(element="thick").parameters()
    assert set(parameters) == set(expected)
    for name, value in expected.items():
        assert parameters[name] == pytest.approx(value, rel=1e-6), name


def test_parameters_tell_the_two_directions_apart():
    # Height 0.02 along y, width 0.01 along z: int y^2 dA = 0.01 0.02^3/12, int z^2 dA a quarter.
    parameters = add(element="thick", section=Rectangle(width=0.01, height=0.02)).parameters()
    about_z = 0.01 * 0.02**3 / 12
    assert parameters["bending_stiffness"] == pytest.approx(1e8 * about_z)
    assert parameters["bending_stiffness_z"] == pytest.approx(1e8 * about_z)
    assert parameters["bending_stiffness_y"] == pytest.approx(1e8 * about_z / 4)
    assert parameters["inertia_y"] == pytest.approx(4000 * about_z)
    assert parameters["inertia_z"] == pytest.approx(4000 * about_z / 4)


def test_section_inertia_as_in_chronos_unit_test():
    # Chrono's test of the fully parameterised beam, density 7850, 0.1 x 0.1, one element of 1 m:
    # r_y diagonal 0.0218055556 = rho I L/3.
    beam = add(element="thick", end=(1, 0), n_elements=1, section=Rectangle(0.1, 0.1),
               material=Material(2e11, 7850.0))  # fmt: skip
    assert beam.parameters()["inertia_y"] / 3 == pytest.approx(0.0218055556, abs=5e-11)


@pytest.mark.parametrize(
    ("end", "up", "axes"),
    [
        ((1, 0, 0), None, [[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        ((0, 3, 0), None, [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
        ((-1, 0, 0), None, [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]),
        ((0, 0, 2), None, [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
        ((1, 0, 0), (5, 0, 2), [[1, 0, 0], [0, 0, 1], [0, -1, 0]]),
    ],
)
def test_axes_of_the_section_in_space(end, up, axes):
    beam = add(Scene(SPATIAL), element="thick", start=(0, 0, 0), end=end, up=up)
    np.testing.assert_allclose(beam.axes, axes, atol=1e-15)


def test_axes_are_a_right_handed_frame_and_agree_with_the_plane():
    beam = add(Scene(SPATIAL), element="thick", start=(1, 2, 3), end=(-2, 0.5, 4), up=(0.3, 1, 0.2))
    np.testing.assert_allclose(beam.axes @ beam.axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(beam.axes) == pytest.approx(1.0)
    planar = add(end=(3, 4))
    np.testing.assert_allclose(planar.axes, [[0.6, 0.8], [-0.8, 0.6]], atol=1e-15)
    spatial = add(Scene(SPATIAL), start=(0, 0, 0), end=(3, 4, 0))
    np.testing.assert_allclose(spatial.axes[:2, :2], planar.axes, atol=1e-15)


def test_initial_velocities():
    def spin(x):
        return 2.0 * np.column_stack([-x[:, 1], x[:, 0]])

    rod = add(velocity=spin)
    np.testing.assert_allclose(rod.velocity(rod.positions)[-1], [0.0, 4.0])
    falling = add(velocity=(0.0, -3.0))
    np.testing.assert_array_equal(falling.velocity(falling.positions), [[0.0, -3.0]] * 11)


def test_points_on_a_beam():
    rod = add(name="rod")
    assert rod.start == rod.node(0) == rod.at(0.0)
    assert rod.end == rod.node(10) == rod.at(2.0)
    assert rod.at(0.2 * 3) == rod.node(3)  # 0.6000000000000001: rounding, not a place
    inside = rod.at(1.25)
    assert (inside.index, inside.is_node) == (6, False)
    assert inside.xi == pytest.approx(0.25)
    assert inside.s == pytest.approx(1.25)
    np.testing.assert_allclose(inside.position, [1.25, 0.0])
    np.testing.assert_array_equal(rod.end.position, [2.0, 0.0])
    assert repr(inside) == "rod at s = 1.25 m"
    assert len({rod.start, Point(rod, 0), rod.end}) == 2


@pytest.mark.parametrize(
    ("point", "message"),
    [
        (lambda rod: rod.node(11), "beam 0 has nodes 0 to 10, there is no node 11"),
        (lambda rod: rod.node(-1), "there is no node -1; its last one is `.end`"),
        (lambda rod: rod.node(2.0), "node of beam 0 must be an integer, got 2.0"),
        (lambda rod: rod.at(2.1), "s = 2.1 m lies outside beam 0: it runs from 0 to 2 m"),
        (lambda rod: rod.at(-0.1), "s = -0.1 m lies outside beam 0"),
        (lambda rod: rod.at(1e308), "lies outside beam 0: it runs from 0 to 2 m"),
        (lambda rod: rod.at(-1e308), "lies outside beam 0: it runs from 0 to 2 m"),
        (lambda rod: rod.at(np.nan), "arc coordinate s on beam 0 must be finite, got nan m"),
    ],
)
def test_points_that_are_not_on_it(point, message):
    with pytest.raises(InputError, match=message):
        point(add())


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"element": "thinn"}, "did you mean 'thin'\\? Valid are 'string', 'l2t2'"),
        ({"element": "Thick"}, "did you mean 'thick'"),
        ({"element": None}, "unknown element None: valid are 'string', 'l2t2', 'thin', 'thick'"),
        ({"end": (0, 0)}, r"beam 0 has zero length: start and end are both at \(0, 0\) m, move"),
        ({"start": (1, 1), "end": (1, 1 + 1e-15)}, "zero length"),
        ({"start": (np.nan, 0)}, "start of beam 0 must be finite, but its x component is nan m"),
        ({"end": (2, 0, 0)}, "end of beam 0 has 3 components, but the scene is planar"),
        ({"n_elements": 0}, "n_elements of beam 0 must be an integer of at least 1, got 0"),
        ({"n_elements": 2.5}, "n_elements of beam 0 must be an integer, got 2.5"),
        ({"section": 0.01}, "a Circle, IBeam, Polygon, Rectangle, Section, Taper or Tube, got 0"),
        ({"material": 1e8}, "material of beam 0 must be a Material, got 100000000.0"),
        ({"strain": "biott"}, "unknown strain 'biott': did you mean 'biot'"),
        ({"element": "l2t2", "strain": "biot"},
         "'l2t2', which has no option strain .its options: none.: leave strain='biot' out or take "
         "'thin'"),
        ({"element": "string", "strain": "green"}, "'string', which has no option strain"),
        ({"curvature": "axis"}, "'thin', which has no option curvature"),
        ({"curvature": "section"}, "'thin', which has no option curvature .its options: strain.:"),
        ({"element": "thick", "strain": "biot"},
         "has no option strain .its options: curvature and section_strain."),
        ({"section_strain": "nodel"}, "unknown section_strain 'nodel': did you mean 'nodal'"),
        ({"rest": "strait"}, "unknown rest of beam 0 'strait': did you mean 'straight'"),
        ({"up": (0, 1, 0)}, "`up` of beam 0 has no meaning in a planar scene"),
        ({"velocity": (0, 0, 1)}, "velocity of beam 0 has 3 components, but the scene is planar"),
        ({"velocity": (0, np.nan)}, "velocity of beam 0 must be finite"),
        ({"velocity": lambda x: x[:, 0]},
         r"velocity of beam 0 returned shape \(11,\) for positions of shape \(11, 2\)"),
        ({"velocity": lambda x: np.where(x > 1.1, np.nan, x)},
         r"velocity of beam 0 must be finite, got \[nan  0.\] at \(1.2, 0\) m"),
        ({"velocity": lambda x: "fast"},
         "the result of velocity of beam 0 must be an array of numbers, got 'fast'"),
        ({"velocity": lambda x: 1.0 / 0.0},
         "velocity of beam 0 failed for an array of 11 reference positions, .*: ZeroDivisionError"),
        ({"velocity": lambda x: x[:, 2]}, "velocity of beam 0 failed for .*: IndexError: index 2"),
        ({"velocity": lambda: 1.0}, "velocity of beam 0 failed for .*: TypeError"),
        ({"name": ""}, "name of a beam must be a non-empty string"),
        ({"start": (1e300, 0)}, r"beam 0 has an end beyond 1e\+150 m"),
        ({"end": (1e300, 0)}, r"beam 0 has an end beyond 1e\+150 m"),
        ({"section": Circle(1e10), "material": Material(1e300, 1.0)},
         "axial_stiffness of beam 0 is inf, beyond the range"),
    ],
)  # fmt: skip
def test_impossible_beams_in_the_plane(changes, message):
    scene = Scene()
    with pytest.raises(InputError, match=message):
        add(scene, **changes)
    assert scene.beams == []


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"end": (2, 0)}, "end of beam 0 has 2 components, but the scene is spatial"),
        ({"element": "l2t2"}, "'l2t2' is a planar element, but the scene of beam 0 is spatial"),
        ({"section": Rectangle(0.01, 0.02)},
         "is the same in all directions, .* inertia_y = 1.66667e-09 m4 and inertia_z = 6.66667e"),
        ({"up": (1, 0, 0)}, "`up` of beam 0 is parallel to the beam"),
        ({"up": (0, 0, 0)}, "length of `up` of beam 0 must be positive, got 0"),
        ({"up": (0, 1)}, "`up` of beam 0 has 2 components"),
    ],
)  # fmt: skip
def test_impossible_beams_in_space(changes, message):
    with pytest.raises(InputError, match=message):
        add(Scene(SPATIAL), **({"start": (0, 0, 0), "end": (2, 0, 0)} | changes))


def test_a_round_section_makes_a_spatial_cable():
    for section in (Circle(0.01), Section(1e-4, 1e-9, 1e-9 * (1 + 1e-12), 2e-9)):
        assert add(Scene(SPATIAL), start=(0, 0, 0), end=(0, 0, 1), section=section).dim == 3


def test_two_beams_cannot_share_a_name():
    scene = Scene()
    add(scene, name="beam 1")
    with pytest.raises(InputError, match="already has a body named 'beam 1': give another name"):
        add(scene, name="beam 1")
    assert [add(scene).name for _ in range(2)] == ["beam 2", "beam 3"]


@pytest.mark.parametrize("gravity", [9.81, (0, 0, 0, 1), (1,), "down", ((1, 2), 3), (0, np.nan)])
def test_gravity_decides_the_dimension(gravity):
    words = "must have 2 components .planar scene. or 3|must be finite, but its y component is nan"
    with pytest.raises(InputError, match=f"gravity ({words})"):
        Scene(gravity)


def test_damping_scales_stiffness_by_time_and_mass_by_rate():
    material = Material(
        1e8, 4000.0, 0.3, axial_damping=2e-3, bending_damping=5e-3, rayleigh=(7.0, 1e-3)
    )
    beam = add(element="thick", material=material, section=Rectangle(0.01, 0.02))
    stiff, viscous = beam.stiffnesses(), beam.viscosities()
    assert viscous.pop("poisson_ratio") == 0.3
    for name, value in viscous.items():
        if name in ("axial_stiffness", "youngs_modulus_area", "shear_modulus_area", "lame_area"):
            expected = 3e-3
        else:
            expected = 7.0 if name in ("mass_per_length", "inertia_y", "inertia_z") else 6e-3
        assert value == pytest.approx(expected * stiff[name]), name
    assert set(viscous) == set(stiff) - {"poisson_ratio"}
    assert beam.strains_damped
    assert beam.masses_damped


@pytest.mark.parametrize(
    ("damping", "strain", "mass"),
    [
        ({}, False, False),
        ({"axial_damping": 1e-3}, True, False),
        ({"bending_damping": 1e-3}, True, False),
        ({"rayleigh": (0.0, 1e-3)}, True, False),
        ({"rayleigh": (1.0, 0.0)}, False, True),
    ],
)
def test_a_beam_says_what_is_damped(damping, strain, mass):
    beam = add(material=Material(1e8, 4000.0, **damping))
    assert (beam.strains_damped, beam.masses_damped) == (strain, mass)
