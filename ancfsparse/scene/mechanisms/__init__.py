"""Joints between two bodies and couplings of joint coordinates."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.mechanisms.gear import Gear as Gear
    from ancfsparse.scene.mechanisms.prescribed_joint import PrescribedJoint as PrescribedJoint
    from ancfsparse.scene.mechanisms.sliding_joint import (
        Slide as Slide,
        elements_under as elements_under,
    )
    from ancfsparse.scene.mechanisms.two_body_joint import (
        Cylindrical as Cylindrical,
        Prismatic as Prismatic,
        Revolute as Revolute,
        TwoBodyJoint as TwoBodyJoint,
        Universal as Universal,
    )
    from ancfsparse.scene.mechanisms.weld import Weld as Weld
    from ancfsparse.scene.mechanisms.winch import Winch as Winch

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
