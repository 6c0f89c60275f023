"""Hanging ropes and nets, initially at rest.

`n_elements` is the number of elements of the rope.
"""

from __future__ import annotations

import numpy as np

from ancfsparse.checks import check_count
from ancfsparse.problems.flexible import add_cable, cable
from ancfsparse.problems.mechanism import GRAVITY, Mechanism
from ancfsparse.scene import Circle, Material, Ramp, Scene


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
