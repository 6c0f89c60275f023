"""The paper's pendulum and the static benchmarks for large bending."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ancfsparse.checks import check_choice, check_positive
from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import OPTIONS
from ancfsparse.scene import AnySection, Beam, Circle, Material, Rectangle, Scene

# Further arguments of a problem, as in `Scene.add_beam`.
ELEMENT_OPTIONS = tuple(dict.fromkeys(name for options in OPTIONS.values() for name in options))


class Problem(NamedTuple):
    """A scene and its one beam: ``scene, rod = pendulum()``.

    Attributes
    ----------
    scene : Scene
        The scene.
    rod : Beam
        Its beam, along +x from the origin.
    """

    scene: Scene
    rod: Beam


def pendulum(
    element: str = "thin",
    n_elements: int | str = 10,
    dim: int | None = None,
    nu: float = 0.3,
    youngs_modulus: float = 1e8,
    as_constraint: bool = False,
    **options: str,
) -> Problem:
    """Set up the flexible pendulum of the paper.

    A rod of 2 m with a 0.01 m square section and 4000 kg/m3 starts at rest, straight along +x,
    pinned at the origin, and falls under 9.81 m/s2 in -y.

    Parameters
    ----------
    element : str, optional
        ``"string"``, ``"l2t2"``, ``"thin"`` or ``"thick"``; or ``"auto"``, for a plan.
    n_elements : int or "auto", optional
        Number of elements.
    dim : int, optional
        2 or 3; by default 3 for ``"thick"`` and 2 for the others.
    nu : float, optional
        Poisson's ratio, used by ``"thick"`` only.  The paper does not state it.
    youngs_modulus : float, optional
        Young's modulus [Pa].
    as_constraint : bool, optional
        Add multipliers for the pin instead of fixing coordinates.
    **options : str
        Options of the element, as in `Scene.add_beam`.
    """
    material = Material(youngs_modulus, 4000.0, nu)
    problem = _rod(element, n_elements, dim, 2.0, Rectangle(0.01, 0.01), material, -9.81, **options)
    problem.scene.pin(problem.rod.start, as_constraint=as_constraint)
    return problem


def cantilever(
    element: str = "thin",
    n_elements: int = 4,
    dim: int | None = None,
    nu: float = 0.3,
    load: float = 3.0,
    **options: str,
) -> Problem:
    """Set up the cantilever of Gerstmayr and Irschik (2008) under a dead force at its tip.

    A beam of 2 m with a 0.1 m square section and 2.07e11 Pa is clamped at the origin, stretch
    free, and bent by a force in -y.  There is no gravity.

    Parameters
    ----------
    element, n_elements, dim, nu, **options
        As in `pendulum`.
    load : float, optional
        ``F L^2 / (E I)`` [-]; 3 is the published load.
    """
    problem = _steel(element, n_elements, dim, nu, **options)
    _bend(problem, load)
    return problem


def elastica(
    load: float = 1.0,
    element: str = "thin",
    n_elements: int = 16,
    dim: int | None = None,
    nu: float = 0.3,
    slenderness: float = 1e3,
    **options: str,
) -> Problem:
    """Set up a cantilever of 1 m so slender that it is close to Euler's elastica.

    Parameters
    ----------
    load : float, optional
        ``F L^2 / (E I)`` [-], a dead force in -y at the tip.
    element, n_elements, dim, nu, **options
        As in `pendulum`.
    slenderness : float, optional
        Length over radius of gyration [-].  The beam stretches by about ``load`` over its
        square, so the tip deviates from the elastica by this.
    """
    section = Circle(4.0 / check_positive("slenderness", slenderness))
    problem = _rod(
        element, n_elements, dim, 1.0, section, Material(2.07e11, 7850.0, nu), 0.0, **options
    )
    problem.scene.clamp(problem.rod.start)
    _bend(problem, load)
    return problem


def roll_up(
    element: str = "thin",
    n_elements: int = 8,
    dim: int | None = None,
    nu: float = 0.3,
    turns: float = 1.0,
    **options: str,
) -> Problem:
    """Set up the beam of `cantilever` bent into a circle by a moment at its tip.

    Parameters
    ----------
    element, n_elements, dim, nu, **options
        As in `pendulum`.
    turns : float, optional
        ``M L / (2 pi E I)`` [-]; 1 closes the circle of an inextensible beam.
    """
    problem = _steel(element, n_elements, dim, nu, **options)
    scene, rod = problem
    moment = 2.0 * math.pi * turns * rod.parameters()["bending_stiffness"] / rod.length
    scene.point_moment(rod.end, moment if scene.dim == 2 else (0.0, 0.0, moment))
    return problem


def _rod(
    element: str,
    n_elements: int | str,
    dim: int | None,
    length: float,
    section: AnySection,
    material: Material,
    gravity: float,
    **options: Any,
) -> Problem:
    if dim is None:
        dim = 3 if element == "thick" else 2
    if dim not in (2, 3):
        raise InputError(f"dim must be 2 (planar) or 3 (spatial), got {dim!r}")
    for option in options:
        check_choice("option of a problem", option, ELEMENT_OPTIONS)
    out_of_plane = (0.0,) * (dim - 2)
    scene = Scene((0.0, gravity, *out_of_plane))
    ends = (0.0, 0.0, *out_of_plane), (length, 0.0, *out_of_plane)
    rod = scene.add_beam(element, *ends, n_elements, section, material, **options)
    return Problem(scene, rod)


def _steel(element: str, n_elements: int, dim: int | None, nu: float, **options: str) -> Problem:
    material = Material(2.07e11, 7850.0, nu)
    problem = _rod(element, n_elements, dim, 2.0, Rectangle(0.1, 0.1), material, 0.0, **options)
    problem.scene.clamp(problem.rod.start)
    return problem


def _bend(problem: Problem, load: float) -> None:
    scene, rod = problem
    force = load * rod.parameters()["bending_stiffness"] / rod.length**2
    scene.point_force(rod.end, (0.0, -force, 0.0)[: scene.dim])
