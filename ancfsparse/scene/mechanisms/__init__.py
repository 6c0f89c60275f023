"""Joints between two bodies and couplings of joint coordinates."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.mechanisms.gear import Gear
    from ancfsparse.scene.mechanisms.prescribed_joint import PrescribedJoint
    from ancfsparse.scene.mechanisms.sliding_joint import Slide, elements_under
    from ancfsparse.scene.mechanisms.two_body_joint import (
        Cylindrical,
        Prismatic,
        Revolute,
        Universal,
    )
    from ancfsparse.scene.mechanisms.weld import Weld
    from ancfsparse.scene.mechanisms.winch import Winch

__all__ = [
    "Cylindrical",
    "Gear",
    "PrescribedJoint",
    "Prismatic",
    "Revolute",
    "Slide",
    "Universal",
    "Weld",
    "Winch",
    "elements_under",
]

_MODULES = {
    "Cylindrical": "two_body_joint",
    "PrescribedJoint": "prescribed_joint",
    "Gear": "gear",
    "Prismatic": "two_body_joint",
    "Revolute": "two_body_joint",
    "Slide": "sliding_joint",
    "Universal": "two_body_joint",
    "Weld": "weld",
    "Winch": "winch",
    "elements_under": "sliding_joint",
}

__getattr__ = on_demand(__name__, _MODULES)
