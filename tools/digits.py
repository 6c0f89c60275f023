"""Write positions of some motions with all their digits, and compare those of two machines.

``digits.py FILE`` runs the motions and writes the positions of their ends; ``digits.py --compare
FILE FILE`` prints the largest distance per motion and fails if one is above `TOLERANCE`.
"""

from __future__ import annotations

import json
import platform
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

import ancfsparse as ancf
from ancfsparse.dispatch import instruction_set

TOLERANCE = 1e-13
"""m.  Rounding of positions of about 1 m, through some hundred steps, came to 1e-14."""

RUBBER = ancf.Material(youngs_modulus=1e8, density=4000, poisson_ratio=0.3)


def pendulum(element: str) -> np.ndarray:
    """Return positions of the tip of README.md's pendulum, m, each 0.01 s."""
    scene = ancf.Scene(gravity=(0.0, -9.81))
    rod = scene.add_beam(
        element, (0, 0), (2, 0), 10, section=ancf.Rectangle(0.01, 0.01), material=RUBBER
    )
    scene.pin(rod.start)
    return ancf.simulate(scene, t_end=0.5, dt=5e-4, save_every=20).position(rod.end)


def net() -> np.ndarray:
    """Return positions of a free corner of a small net, m, each 0.01 s."""
    scene = ancf.Scene(gravity=(0.0, 0.0, -9.81))
    mesh = scene.add_mesh(
        [(x / 6, y / 6, 0.0) for y in range(7) for x in range(7)],
        [(7 * y + x, 7 * y + x + 1) for y in range(7) for x in range(6)]
        + [(7 * y + x, 7 * y + x + 7) for y in range(6) for x in range(7)],
        "thin",
        section=ancf.Circle(0.01),
        material=RUBBER,
    )
    scene.pin(mesh.node(0))
    scene.pin(mesh.node(6))
    return ancf.simulate(scene, t_end=0.2, dt=1e-3, save_every=10).position(mesh.node(48))


MOTIONS: dict[str, Callable[[], np.ndarray]] = {
    "pendulum, thin cable": lambda: pendulum("thin"),
    "pendulum, thick beam": lambda: pendulum("thick"),
    "net": net,
}


def write(path: Path) -> None:
    """Run the motions here and write their positions."""
    ends = {name: run().tolist() for name, run in MOTIONS.items()}
    about = f"{platform.machine()}, modules for {instruction_set()}"
    path.write_text(json.dumps({"machine": about, "positions": ends}), encoding="utf-8")


def compare(one: Path, other: Path) -> int:
    """Print the distances between two files; return 1 if they are too large."""
    first, second = (json.loads(path.read_text(encoding="utf-8")) for path in (one, other))
    print(f"{first['machine']} against {second['machine']}:")
    worst = 0.0
    for name, positions in first["positions"].items():
        distance = float(np.abs(np.subtract(positions, second["positions"][name])).max())
        print(f"  {name:24} {distance:.1e} m")
        worst = max(worst, distance)
    return int(not worst <= TOLERANCE)


if __name__ == "__main__":
    if sys.argv[1] == "--compare":
        sys.exit(compare(Path(sys.argv[2]), Path(sys.argv[3])))
    write(Path(sys.argv[1]))
