"""Reactions, joint forces and element end forces of a solution."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.system.recovery.reactions import reaction

__all__ = ["reaction"]

__getattr__ = on_demand(__name__, {"reactions": "reaction"})
