"""Forces of joints and loads for the arrows of a page."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import AncfError
from ancfsparse.results.export.report.moving_scene import MovingScene
from ancfsparse.scene import PointForce

MAX_ARROWS = (
    24  # more would hide the scene, and the force of a joint takes a pass through all states
)
ROUNDING = 1e-9  # force that is not drawn, over the largest one

Arrow = tuple[str, Vector, Vector]
"""Kind, points (k, dim) [m] and forces (k, dim) [N]."""


def add_forces(page: MovingScene, run: Any) -> None:
    """Add the forces of a run with the states of the page: on bodies at joints, and loads.

    The first forces are taken: loads at points, then joints.  Loads that follow a body, and joints
    whose force is not determined or zero, are left out.
    """
    arrows = list(islice(_forces(run), MAX_ARROWS))
    greatest = max((np.linalg.norm(force, axis=1).max() for *_, force in arrows), default=0.0)
    arrows = [each for each in arrows if np.abs(each[2]).max() > ROUNDING * greatest]
    page.contents["arrows"] = [kind for kind, *_ in arrows]
    if arrows:
        page.contents["force"] = float(greatest)
        page.moving["arrow points"] = np.concatenate([points for _, points, _ in arrows], axis=1)
        page.moving["arrow forces"] = np.concatenate([force for *_, force in arrows], axis=1)


def _forces(run: Any) -> Iterator[Arrow]:
    """Yield loads and joint forces."""
    for load in run.system.external_loads:
        if isinstance(load, PointForce) and not load.follow:
            values = np.stack([np.asarray(load.at(float(t))) for t in run.t])
            yield "load", run.position(load.node), values
    for joint in run.system.scene.joints:
        try:
            force = run.joint_force(joint).force
        except AncfError:  # others constrain the same coordinates
            continue
        if np.isfinite(force).all():
            yield "reaction", run.position(joint.nodes[0]), force
