"""Hanging ropes and nets, and chains on a seabed, initially at rest.

`n_elements` is the number of elements of the rope.
"""

from __future__ import annotations

import math

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count
from ancfsparse.problems.flexible import add_cable, cable
from ancfsparse.problems.mechanism import GRAVITY, Mechanism
from ancfsparse.scene import Circle, Material, Ramp, Scene, Sine
from ancfsparse.scene.bodies.rigid_shapes import Cylinder
from ancfsparse.scene.force_elements.obstacles import HalfSpace

CHAIN_LENGTH = 120.0  # of a mooring [m]
CHAIN_MASS = 72.0  # of a chain without studs of 60 mm [kg/m]
CHAIN_WEIGHT = 614.0  # of it in sea water [N/m]
CHAIN_STIFFNESS = 3e8  # EA [N]
CHAIN_SECTION = Circle(0.108)  # a rod of steel with the mass of the chain
CHAIN_MATERIAL = Material(
    CHAIN_STIFFNESS / CHAIN_SECTION.area, CHAIN_MASS / CHAIN_SECTION.area,
    axial_damping=0.02, rayleigh=(0.1, 0.0),
)  # fmt: skip
HORIZONTAL = 3e4  # component of the tension at the platform [N]
VERTICAL = 4.3e4  # the other one [N]
SEABED_STIFFNESS = 1e5  # of the contact [N/m2]
SURGE = 3.0  # amplitude of the platform [m]
PERIOD = 10.0  # of its motion [s]
PLATFORM_RADIUS = 5.0  # [m]
PLATFORM_HEIGHT = 6.0  # [m]


def catenary(n_elements: int = 128) -> Mechanism:
    """Return a rope of 24 m and 20 mm that hangs between pins 20 m apart, one of them 5 m higher.

    It is made of strings of 1e9 Pa and 1200 kg/m3, and starts in equilibrium.

    Quantities: ``middle`` of the rope [m]; ``pull``, the reaction at its lower end [N].
    """
    scene = Scene((0.0, -GRAVITY))
    n = check_count("n_elements", n_elements, 2)
    section, material = Circle(0.02), Material(1e9, 1200.0)
    rope = scene.add_beam("string", (0, 0), (20, 5), n, section, material, length=24.0, name="rope")
    scene.pin(rope.start)
    scene.pin(rope.end)
    watched = {
        "middle": lambda run: run.position(rope.at(12.0)),
        "pull": lambda run: run.reaction(rope.start),
    }
    return Mechanism(scene, watched, settles=True)


def hanging_net(n: int = 12) -> Mechanism:
    """Return a square net of rubber strings, 4 m wide, that hangs from its corners at rest.

    The strings are 10 mm thick, of 2e6 Pa and 1100 kg/m3, and stress-free in the plane.

    Parameters
    ----------
    n : int, optional
        Meshes along a side, an even number.

    Notes
    -----
    Quantities: ``middle`` of the net, ``rim``, the middle of one side [m]; ``pull``, the reaction
    at a corner [N].
    """
    scene = Scene((0.0, 0.0, -GRAVITY))
    half = check_count("half of the meshes along a side", n // 2, 1)
    across, number = np.arange(2 * half + 1), np.arange((2 * half + 1) ** 2)
    grid = number.reshape(len(across), len(across))
    edges = np.concatenate(
        [np.stack([one.ravel(), other.ravel()], axis=1) for one, other in (
            (grid[:-1], grid[1:]), (grid[:, :-1], grid[:, 1:]))]
    )  # fmt: skip
    x, y = np.divmod(number, len(across))
    nodes = np.stack([x, y, 0 * x], axis=1) * (2.0 / half)
    net = scene.add_mesh(nodes, edges, "string", Circle(0.01), Material(2e6, 1100.0), name="net")
    corners = [net.node(int(k)) for k in grid[[0, 0, -1, -1], [0, -1, 0, -1]]]
    for corner in corners:
        scene.pin(corner)
    middle, rim = (net.node(int(k)) for k in (grid[half, half], grid[0, half]))
    watched = {
        "middle": lambda run: run.position(middle),
        "rim": lambda run: run.position(rim),
        "pull": lambda run: run.reaction(corners[0]),
    }
    return Mechanism(scene, watched, settles=True)


def cable_car(n_elements: int = 160) -> Mechanism:
    """Return a carriage of 100 kg that runs without friction along a slack rope of 21 m.

    The rope has EA = 1e6 N, EI = 1000 N m2 and 1.5 kg/m, and hangs between pins 20 m apart, one of
    them 1 m higher.  A force of 300 N towards the lower end acts on the carriage, whose centre is
    1 m below the rope, and vanishes within 0.5 s.

    Quantities: the position of the ``carriage`` on the rope [m]; ``pull``, the reaction at the
    lower end of the rope [N].
    """
    scene = Scene((0.0, -GRAVITY))
    make = cable(1e6, 1000.0, 1.5)
    rope = add_cable(scene, "rope", (0, 0), (20, 1), n_elements, make, min_elements=5, length=21.0)
    scene.pin(rope.start)
    scene.pin(rope.end)
    position = rope.positions[n_elements // 5]
    carriage = scene.add_body(
        mass=100.0, inertia=20.0, centre=(0, -1), position=position, name="carriage"
    )
    scene.slide(carriage.origin, rope)
    force = -300.0, 0.0
    scene.point_force(carriage.origin, Ramp((300.0, 0.0), 0.5, smooth=True) + force)
    watched = {
        "carriage": lambda run: run.position(carriage.origin),
        "pull": lambda run: run.reaction(rope.start),
    }
    return Mechanism(scene, watched, settles=True)


def _trace_catenary(s: Vector) -> tuple[Vector, Vector]:
    """Return distance from the anchor and height above the seabed at arc coordinates s (n,) [m].

    The chain lies on the seabed, without friction, up to where the rest of it weighs `VERTICAL`.
    """
    weight = np.maximum(CHAIN_WEIGHT * s - (CHAIN_WEIGHT * CHAIN_LENGTH - VERTICAL), 0.0)
    lying = np.minimum(s, CHAIN_LENGTH - VERTICAL / CHAIN_WEIGHT)
    radius = HORIZONTAL / CHAIN_WEIGHT
    ratio = weight / HORIZONTAL
    distance = lying + radius * np.arcsinh(ratio) + HORIZONTAL * s / CHAIN_STIFFNESS
    height = radius * (np.hypot(1.0, ratio) - 1.0) + weight**2 / (
        2.0 * CHAIN_STIFFNESS * CHAIN_WEIGHT
    )
    return distance, height


def mooring(n_elements: int = 60) -> Mechanism:
    """Return a platform whose surge moves three chains of 120 m that lie on the seabed in part.

    A chain has `n_elements` strings, 72 kg/m, a weight of 614 N/m in water and EA = 3e8 N.  The
    platform, 37 m above the seabed, moves to and fro by 6 m within 10 s.  Water has no drag.  It
    starts in equilibrium, which is that of an elastic catenary with a tension of 30 kN horizontally
    and 43 kN vertically at the platform.

    Quantities: ``anchor``, the horizontal reaction at the chain that is parallel to the surge [N];
    ``fairlead``, its tension at the platform [N].
    """
    scene = Scene((0.0, 0.0, -GRAVITY))
    arcs = np.linspace(0.0, CHAIN_LENGTH, check_count("n_elements", n_elements, 10) + 1)
    distance, height = _trace_catenary(arcs)
    platform = scene.add_body(
        Cylinder(PLATFORM_HEIGHT, PLATFORM_RADIUS, axis="z"), mass=4e5,
        position=(0, 0, height[-1]), name="platform",
    )  # fmt: skip
    surge = scene.prismatic(platform.origin, axis=(1, 0, 0))
    # It starts at rest, at one end of its way.
    scene.drive_joint(surge, Sine(SURGE, 1.0 / PERIOD, phase=-0.5 * math.pi) + SURGE)
    radius = 0.5 * CHAIN_SECTION.diameter
    # A chain that lies on the seabed sinks in by its weight, so that its axis is level with the
    # anchor.
    floor = HalfSpace((0.0, 0.0, CHAIN_WEIGHT / SEABED_STIFFNESS - radius), (0.0, 0.0, 1.0))
    chains, fairleads = [], []
    for k in range(3):
        angle = math.radians(60.0 + 120.0 * k)
        away = np.array([math.cos(angle), math.sin(angle)])
        outer = PLATFORM_RADIUS + distance[-1] - distance
        points = np.column_stack([np.outer(outer, away), height])
        chain = scene.add_beam(
            "string", curve=points, n_elements=n_elements, section=CHAIN_SECTION,
            material=CHAIN_MATERIAL, rest="straight", length=CHAIN_LENGTH, name=f"chain {k}",
        )  # fmt: skip
        scene.pin(chain.start)
        fairlead = platform.at((*(PLATFORM_RADIUS * away), 0.0))
        fairleads.append(scene.connect(chain.end, fairlead))
        scene.distributed_force(chain, (0.0, 0.0, CHAIN_MASS * GRAVITY - CHAIN_WEIGHT))  # buoyancy
        scene.contact(chain, floor, stiffness=SEABED_STIFFNESS)
        chains.append(chain)
    watched = {
        "anchor": lambda run: np.linalg.norm(run.reaction(chains[1].start)[..., :2], axis=-1),
        "fairlead": lambda run: np.linalg.norm(run.joint_force(fairleads[1]).force, axis=-1),
    }
    return Mechanism(scene, watched, settles=True)
