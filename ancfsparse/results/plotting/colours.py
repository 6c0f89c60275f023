"""Colours of elements by a quantity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.results.fields.quantities import ELEMENT_MEANS, evaluate_quantity, label_of
from ancfsparse.results.geometry.scene_outline import Outline
from ancfsparse.results.plotting.canvas import Canvas
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.system import System

COLOURS = ("N", *ELEMENT_MEANS)
"""Quantities without components, one value for each element."""
COLOUR_MAP = ListedColormap(plt.get_cmap("viridis_r")(np.linspace(0.12, 1.0, 256)))
"""Light colours for small values, which are visible on white, and dark ones for large values."""
OTHER_COLOUR = "0.4"  # of rigid bodies, ropes and springs
LINE_WIDTH = 1.8  # of coloured lines, over the width of others
BAR_WIDTH = 0.12  # inch
BAR_GAP = 0.15  # inch, from planar axes
BAR_HEIGHT = 0.6  # over the height of axes in perspective
BAR_LEFT = 0.25  # inch, from the edge of a figure in perspective


@dataclass(frozen=True)
class Colours:
    """A quantity of the elements of every beam in k states.

    Attributes
    ----------
    label : str
        Its name and unit.
    values : list of ndarray, each of shape (k, n_elements)
        Its values.
    """

    label: str
    values: list[Vector]

    @property
    def limits(self) -> tuple[float, float]:
        """Smallest and largest value."""
        return min(map(np.min, self.values)), max(map(np.max, self.values))


def evaluate_colours(
    system: System, states: StateHistory, what: object, outline: Outline
) -> Colours:
    """Evaluate a quantity at the elements of each beam and mesh of an outline."""
    name = check_choice("colour", what, COLOURS)
    bodies: list[Any] = [system.scene.body(part.name) for part in outline.parts]
    if not bodies:
        raise InputError(f"colour={name!r} is for beams and meshes: leave it out for rigid bodies")
    values = [evaluate_quantity(system, states, name, body) for body in bodies]
    return Colours(label_of(name), values)


def draw_coloured(canvas: Canvas, colours: Colours) -> None:
    """Draw all states of a scene with the colours of a quantity, and a colour bar."""
    norm = Normalize(*colours.limits)
    for state in range(len(colours.values[0])):
        artists = canvas.draw(state, OTHER_COLOUR)
        for artist, values in zip(artists, colours.values, strict=False):
            artist.set(color=None, array=values[state], cmap=COLOUR_MAP, norm=norm)
            artist.set_linewidth(LINE_WIDTH * canvas.film.width)
    mapping, figure, ax = ScalarMappable(norm, COLOUR_MAP), canvas.figure, canvas.ax
    if not canvas.is_new:
        figure.colorbar(mapping, ax=ax, label=colours.label)
        return
    across = float(figure.get_figwidth())
    box = ax.get_position()
    if len(canvas.axes) == 2:
        frame = box.x1 + BAR_GAP / across, box.y0, BAR_WIDTH / across, box.height
    else:
        height = BAR_HEIGHT * box.height
        frame = BAR_LEFT / across, box.y0 + 0.5 * (box.height - height), BAR_WIDTH / across, height
    figure.colorbar(mapping, cax=figure.add_axes(frame), label=colours.label)
