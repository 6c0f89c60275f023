"""Scenes of variable size: chains, nets, cubic lattices, octet trusses."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice, check_count, check_finite
from ancfsparse.problems.benchmarks import Problem
from ancfsparse.scene import Beam, Material, Mesh, Rectangle, Scene
from ancfsparse.scene.bodies.body import VelocityField

ELEMENT_LENGTH = 0.2  # [m]

# Young's modulus [Pa] and density [kg/m3] of the cables of a lattice.
LATTICE_MATERIALS = {"soft": (1e8, 1000.0), "steel": (2.1e11, 7800.0)}

# Speeds [m/s] and numbers of elements of the waves in each motion.
WAVES: dict[str, list[tuple[float, int]]] = {
    "rest": [],
    "smooth": [(2.0, 80)],
    "rough": [(4.0, 40), (4.0, 8)],
}
MOTIONS = tuple(WAVES)


class Net(NamedTuple):
    """A net: ``scene, along, across = net(30)``.

    Attributes
    ----------
    scene : Scene
        The scene.
    along, across : list of Beam
        Its cables in +x, in order of z, and in +z, in order of x.
    """

    scene: Scene
    along: list[Beam]
    across: list[Beam]


class Lattice(NamedTuple):
    """A lattice or a truss: ``scene, mesh = lattice(10)``.

    Attributes
    ----------
    scene : Scene
        The scene.
    mesh : Mesh
        Its cables.
    """

    scene: Scene
    mesh: Mesh


def chain(n_elements: int = 1000, motion: str = "rest", element: str = "l2t2") -> Problem:
    """Set up a planar cable of many equal elements, pinned at the origin, falling.

    Section and material are taken from `pendulum`; the length of an element is 0.2 m.

    Parameters
    ----------
    n_elements : int, optional
        Number of elements.
    motion : {"rest", "smooth", "rough"}, optional
        Initial velocities: none, a long wave, or two short waves, whose amplitudes do not grow with
        the length of the chain (see `WAVES`).
    element : str, optional
        ``"l2t2"`` or ``"thin"``.
    """
    check_count("n_elements", n_elements)
    scene = Scene((0.0, -9.81))
    end = ELEMENT_LENGTH * n_elements, 0.0
    velocity = _circular_waves(_waves(motion))
    section, material = _cable()
    rod = scene.add_beam(element, (0, 0), end, n_elements, section, material, velocity=velocity)
    scene.pin(rod.start)
    return Problem(scene, rod)


def net(n_nodes: int = 30, motion: str = "rest") -> Net:
    """Set up a square net of thin cables in the x-z plane, fixed at its corners, falling in -y.

    Section and material are taken from `pendulum`; the cables cross every 0.2 m and share the
    position of each crossing.

    Parameters
    ----------
    n_nodes : int, optional
        Crossings along a side, so ``2 n (n - 1)`` elements.
    motion : {"rest", "smooth", "rough"}, optional
        Initial velocities: none, or standing waves of about the lengths in `chain`.
    """
    check_count("n_nodes", n_nodes, 2)
    scene = Scene((0.0, -9.81, 0.0))
    side = ELEMENT_LENGTH * (n_nodes - 1)
    velocity = _membrane_waves(_waves(motion), side)
    section, material = _cable()

    def cable(start: tuple[float, ...], end: tuple[float, ...]) -> Beam:
        return scene.add_beam("thin", start, end, n_nodes - 1, section, material, velocity=velocity)

    positions = ELEMENT_LENGTH * np.arange(n_nodes)
    along = [cable((0.0, 0.0, z), (side, 0.0, z)) for z in positions]
    across = [cable((x, 0.0, 0.0), (x, 0.0, side)) for x in positions]
    for j, a in enumerate(along):
        for i, b in enumerate(across):
            scene.connect(a.node(i), b.node(j))
    for cable_at_edge in (along[0], along[-1]):
        scene.pin(cable_at_edge.start)
        scene.pin(cable_at_edge.end)
    return Net(scene, along, across)


def lattice(
    n_nodes: int = 10,
    motion: str = "rest",
    youngs_modulus: float = 1e8,
    density: float = 1000.0,
    jitter: float = 0.0,
) -> Lattice:
    """Set up a cubic lattice of thin cables, fixed at the four corners of its top, falling in -z.

    The cables run along all three axes, cross every 0.2 m and share the position of each crossing;
    their section is taken from `pendulum`.

    Parameters
    ----------
    n_nodes : int, optional
        Crossings along a side, so ``3 n^2 (n - 1)`` elements.
    motion : {"rest", "smooth", "rough"}, optional
        Initial velocities: none, or standing waves of about the lengths in `chain` and half the
        amplitude, with the surface at rest.
    youngs_modulus, density : float, optional
        Material of the cables [Pa], [kg/m3].
    jitter : float, optional
        Largest random displacement of crossings, over their distance; the eight corners stay.
        Cables that bend there by less than 5 degrees start with the corresponding stress.
    """
    n = check_count("n_nodes", n_nodes, 2)
    jitter = check_finite("jitter", jitter)
    number = np.arange(n**3).reshape(n, n, n)
    places = np.stack(np.unravel_index(number.ravel(), number.shape), axis=1)
    shift = jitter * np.random.default_rng(0).uniform(-1.0, 1.0, places.shape)
    shift[number[:: n - 1, :: n - 1, :: n - 1]] = 0.0
    ends = [(number[:-1], number[1:]), (number[:, :-1], number[:, 1:])]
    ends.append((number[:, :, :-1], number[:, :, 1:]))
    edges = np.concatenate([np.stack([a.ravel(), b.ravel()], axis=1) for a, b in ends])
    return _hang(places, edges, ELEMENT_LENGTH, motion, Material(youngs_modulus, density), shift)


def octet(
    n_cells: int = 4,
    motion: str = "rest",
    youngs_modulus: float = 1e8,
    density: float = 1000.0,
) -> Lattice:
    """Set up a cube of an octet truss, fixed at the four corners of its top, falling in -z.

    Its nodes form a face-centred cubic lattice, with a cable from each to its twelve neighbours at
    0.2 m: octahedra and tetrahedra that are rigid also with hinges.  Cables continue along the
    diagonals of the faces of the cells; their section is taken from `pendulum`.

    Parameters
    ----------
    n_cells : int, optional
        Cubic cells along a side, so ``12 n^2 (2 n + 1)`` elements.
    motion, youngs_modulus, density
        As in `lattice`.
    """
    m = 2 * check_count("n_cells", n_cells) + 1
    grid = np.stack(np.unravel_index(np.arange(m**3), (m, m, m)), axis=1)
    is_node = grid.sum(axis=1) % 2 == 0
    number, nodes = np.cumsum(is_node).reshape(m, m, m) - 1, grid[is_node]
    edges = []
    for direction in ((1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1)):
        ends = nodes + np.array(direction)
        inside = np.flatnonzero(np.all((ends >= 0) & (ends < m), axis=1))
        edges.append(np.stack([inside, number[tuple(ends[inside].T)]], axis=1))
    return _hang(
        nodes,
        np.concatenate(edges),
        ELEMENT_LENGTH / math.sqrt(2.0),
        motion,
        Material(youngs_modulus, density),
    )


def _hang(
    grid: NDArray[np.int64],
    edges: NDArray[np.int64],
    spacing: float,
    motion: str,
    material: Material,
    shift: Vector | float = 0.0,
) -> Lattice:
    """Return a cube of thin cables pinned at the four corners of its top."""
    scene = Scene((0.0, 0.0, -9.81))
    top = int(grid.max())
    mesh = scene.add_mesh(
        spacing * (grid + shift),
        edges,
        "thin",
        _cable()[0],
        material,
        velocity=_lattice_waves(_waves(motion), spacing * top),
    )
    for corner in np.flatnonzero(np.all(grid % top == 0, axis=1) & (grid[:, 2] == top)):
        scene.pin(mesh.node(int(corner)))
    return Lattice(scene, mesh)


def _cable() -> tuple[Rectangle, Material]:
    return Rectangle(0.01, 0.01), Material(1e8, 4000.0)


def _waves(motion: str) -> list[tuple[float, int]]:
    """Return the speed [m/s] and the number of elements of each wave."""
    check_choice("motion", motion, MOTIONS)
    return WAVES[motion]


def _circular_waves(waves: list[tuple[float, int]]) -> VelocityField | None:
    """Return velocities of a chain along x on circles whose phase varies along it."""

    def chain_wave(x: Vector, speed: float, elements: int) -> Vector:
        phase = 2.0 * math.pi / (ELEMENT_LENGTH * elements) * x[:, 0]
        return speed * np.stack([np.cos(phase) - 1.0, np.sin(phase)], axis=1)

    return _sum_waves(waves, chain_wave)


def _membrane_waves(waves: list[tuple[float, int]], side: float) -> VelocityField | None:
    """Return velocities of a net in standing waves normal to it, with its edges at rest."""

    def net_wave(x: Vector, speed: float, elements: int) -> Vector:
        number = _wave_number(side, elements)
        size = speed * np.sin(number * x[:, 0]) * np.sin(number * x[:, 2])
        return size[:, None] * [0.0, 1.0, 0.0]

    return _sum_waves(waves, net_wave)


def _lattice_waves(waves: list[tuple[float, int]], side: float) -> VelocityField | None:
    """Return velocities of a lattice in standing waves, with its surface at rest."""

    def lattice_wave(x: Vector, speed: float, elements: int) -> Vector:
        number = _wave_number(side, elements)
        return np.asarray(0.5 * speed * np.prod(np.sin(number * x), axis=1, keepdims=True))

    return _sum_waves(waves, lattice_wave)


def _wave_number(side: float, elements: int) -> float:
    """Return the wave number nearest to waves of some elements, with nodes at both ends."""
    return max(1, round(2.0 * side / (ELEMENT_LENGTH * elements))) * math.pi / side


def _sum_waves(
    waves: list[tuple[float, int]], velocities: Callable[[Vector, float, int], Vector]
) -> VelocityField | None:
    """Return the sum of the velocities of all waves as a function of positions (k, dim)."""

    def field(x: Vector) -> Vector:
        v = np.zeros_like(x)
        for wave in waves:
            v += velocities(x, *wave)
        return v

    return field if waves else None
