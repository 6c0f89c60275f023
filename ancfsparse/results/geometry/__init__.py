"""Drawable geometry of a scene."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.results.geometry.scene_outline import outline_of

__all__ = ["outline_of"]

__getattr__ = on_demand(__name__, {"outline_of": "scene_outline"})
