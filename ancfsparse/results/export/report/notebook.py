"""Moving scenes in notebooks: frames that contain a page."""

from __future__ import annotations

from html import escape

import numpy as np

from ancfsparse.errors import AncfError
from ancfsparse.results.export.report.moving_scene import make_moving_scene
from ancfsparse.results.export.report.report import ReportedRun, make_film
from ancfsparse.results.export.report.web_page import make_page
from ancfsparse.results.geometry.scene_outline import make_outline
from ancfsparse.scene import Scene
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.system import System

MAX_FRAMES = 200  # fewer than in a report, since a notebook keeps the pages of all its cells
MAX_NUMBERS = 400_000
HEIGHT = 480  # pixels


def show_run(run: ReportedRun) -> str | None:
    """Return the moving scene of a run as HTML; None if it cannot be drawn."""
    try:
        return _frame(make_page(make_film(run, MAX_FRAMES, MAX_NUMBERS), "run"))
    except AncfError:  # such as a run that saved some points only
        return None


def show_scene(scene: Scene) -> str | None:
    """Return a scene at its initial shape as HTML; None if it cannot be drawn."""
    try:
        system = System(scene)
        q = system.q0[None]
        states = StateHistory(q, q, q, np.zeros((1, 0)), np.zeros(1), np.zeros((1, 0)))
        film = make_moving_scene(system, make_outline(system), states, coloured=False)
        return _frame(make_page(film, "scene"))
    except AncfError:  # such as a scene without bodies, or with an element to be chosen
        return None


def _frame(page: str) -> str:
    """Return a frame that contains a page, without access to the notebook."""
    return (
        f'<iframe srcdoc="{escape(page)}" sandbox="allow-scripts" '
        f'style="width: 100%; height: {HEIGHT}px; border: 0"></iframe>'
    )
