"""The initial state of motions and equilibria."""

from __future__ import annotations

from ancfsparse.scene import Scene
from ancfsparse.solve import statics
from ancfsparse.solve.initial_conditions.restart import check_start
from ancfsparse.system import State


def find_initial_state(scene: Scene, start: object) -> tuple[State | None, str]:
    """Return the state of an argument `start`, None for the reference shape.

    Without a `start`, contacts with ``push_out=True`` can move the scene; a description of the
    motion is returned too.
    """
    state = check_start(start)
    if state is None and any(each.separates for each in scene.attachments):
        return statics.separate_bodies(scene)
    return state, ""
