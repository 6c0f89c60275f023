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
        TwoBodyJoint,
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
    "TwoBodyJoint",
    "Universal",
    "Weld",
    "Winch",
    "elements_under",
]

__getattr__ = on_demand(
    __name__,
    {
        "gear": "Gear",
        "prescribed_joint": "PrescribedJoint",
        "sliding_joint": "Slide elements_under",
        "two_body_joint": "Cylindrical Prismatic Revolute TwoBodyJoint Universal",
        "weld": "Weld",
        "winch": "Winch",
    },
)
