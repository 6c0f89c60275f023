"""Plain data of a definition: records, signals, functions of time."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.records.prescribed_motion import define_motion

__all__ = ["define_motion"]

__getattr__ = on_demand(__name__, {"prescribed_motion": "define_motion"})
