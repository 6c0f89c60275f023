"""Beams whose section changes along them, and beams with nodes of their own."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.system import System

STEEL = ancf.Material(2.1e11, 7850.0, poisson_ratio=0.3)
TAPER = ancf.Taper(ancf.Circle(0.1), ancf.Circle(0.2))
NODES = (0.0, 0.05, 0.15, 0.4, 1.0)


SECTION = ancf.Rectangle(0.02, 0.03)


def cantilever(n=None, element="thin", section=SECTION, force=1.0, **options):
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam(element, (0, 0), (2, 0), n, section, STEEL, **options)
    scene.clamp(rod.start)
    scene.point_force(rod.end, (0.0, -force))
    return scene, rod


def test_a_tapered_cantilever_bends_by_the_integral_of_its_compliance():
    """w = int F x^2 / (E I(x)) dx with x from the tip; height from 0.04 m down to 0.02 m."""
    taper = ancf.Taper(ancf.Rectangle(0.02, 0.04), ancf.Rectangle(0.02, 0.02))
    x, w = np.polynomial.legendre.leggauss(20)
    x, w = 1.0 + x, w
    exact = w @ (x**2 / (2.1e11 * 0.02 * (0.02 + 0.01 * x) ** 3 / 12.0))
    errors = []
    for n in (4, 8, 16):
        scene, rod = cantilever(n, section=taper)
        assert System(scene).mass == pytest.approx(7850.0 * 0.02 * 0.03 * 2.0, rel=1e-14)
        errors.append(-ancf.solve_static(scene).displacement(rod.end)[1] / exact - 1.0)
    assert abs(errors[-1]) < 2e-3
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([2.0, 2.0], abs=0.2)


def test_a_taper_between_equal_sections_is_that_section():
    section = ancf.IBeam(width=0.1, height=0.2, web=0.005, flange=0.008)
    kinds = section, ancf.Taper(section, section)
    even, tapered = (cantilever(3, "thick", each)[1].stiffnesses() for each in kinds)
    for name, value in even.items():
        assert_allclose(tapered[name], value, rtol=1e-14)


def test_nodes_stand_where_they_are_given(tmp_path):
    scene, rod = cantilever(nodes=NODES)
    assert rod.n_elements == 4
    assert_allclose(rod.positions[:, 0], 2.0 * np.array(NODES), rtol=1e-15)
    assert_allclose(rod.lengths, 2.0 * np.diff(NODES), rtol=1e-15)
    assert rod.at(0.3).index == 2
    point = rod.at(0.5)
    assert (point.index, point.xi) == (2, pytest.approx(0.4))
    assert point.s == pytest.approx(0.5)
    assert point.position == pytest.approx([0.5, 0.0])
    scene.save(tmp_path / "scene.json")
    again = ancf.Scene.load(tmp_path / "scene.json")
    assert again == scene
    assert_array_equal(System(again).q_ref, System(scene).q_ref)
    scene.point_force(point, (0.0, -1.0))
    fine = scene.refined(3)
    assert fine.beams[0].n_elements == 12
    assert_allclose(fine.beams[0].positions[::3], rod.positions, rtol=1e-14)
    assert fine.loads[-1].node.position == pytest.approx([0.5, 0.0])


def test_uneven_nodes_give_the_deflection_of_even_ones():
    exact = 8.0 / (3.0 * 2.1e11 * 0.02 * 0.03**3 / 12.0)
    scene, rod = cantilever(nodes=NODES)
    assert -ancf.solve_static(scene).displacement(rod.end)[1] == pytest.approx(exact, rel=1e-6)
    free = ancf.Scene((0.0, 0.0, 0.0))
    bar = free.add_beam("thick", (0, 0, 0), (2, 0, 0), nodes=NODES, material=STEEL,
                        section=ancf.Taper(ancf.Circle(0.03), ancf.Circle(0.02)))  # fmt: skip
    system = System(free)
    stiffness = STEEL.youngs_modulus * bar.section.area
    assert system.assembly.strain_energy(system.q_ref) <= 1e-28 * stiffness * bar.length
    assert bar.length == 2.0


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: cantilever(nodes=(0.0, 0.5)), "must be fractions of its length that grow"),
        (lambda: cantilever(nodes=(0.0, 0.5, 0.5, 1.0)), "must be fractions of its length"),
        (lambda: cantilever(3, nodes=NODES), "make 4 elements, but n_elements is 3"),
        (lambda: ancf.Taper(ancf.Circle(0.1), ancf.Tube(0.1, 0.01)), "of one kind"),
        (
            lambda: cantilever(3, section=TAPER, tension=1.0),
            "give the length instead",
        ),
        (
            lambda: ancf.Scene().add_mesh([(0, 0), (1, 0)], [(0, 1)], "thin", TAPER, STEEL),
            "cannot have a Taper",
        ),
    ],
)  # fmt: skip
def test_mistakes(make, words):
    with pytest.raises(InputError, match=re.escape(words)):
        make()


def test_points_do_not_move_to_other_nodes_unseen():
    scene, rod = cantilever(nodes=NODES)
    scene.point_force(rod.node(1), (0.0, 1.0))
    with pytest.raises(InputError, match="has specified nodes: take a multiple of 4"):
        scene.replaced(rod, n_elements=6, nodes=None)
