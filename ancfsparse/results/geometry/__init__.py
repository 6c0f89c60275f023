"""Drawable geometry of a scene."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.results.geometry.scene_outline import make_outline

__all__ = ["make_outline"]

__getattr__ = on_demand(__name__, {"scene_outline": "make_outline"})
