"""Joints: each lowers itself to coordinates that are fixed or shared, and to equations.

A new joint is a file beside the others and a method of `Scene`; nothing else asks what kind it is.
"""

from ancfsparse.scene.bodies.body import LINEAR, Builder, Led
from ancfsparse.scene.geometry.positions import SAME_PLACE
from ancfsparse.scene.joints.clamp import Clamp
from ancfsparse.scene.joints.connect import Connect
from ancfsparse.scene.joints.constrained_points import Holds
from ancfsparse.scene.joints.joint import (
    Joint,
    check_end,
    check_node,
    check_other_body,
    check_point,
    check_turns,
)
from ancfsparse.scene.joints.pin import Pin
from ancfsparse.scene.joints.prescribed_point import Drive
from ancfsparse.scene.joints.rod import Rod

__all__ = [
    "LINEAR",
    "SAME_PLACE",
    "Builder",
    "Clamp",
    "Connect",
    "Drive",
    "Holds",
    "Joint",
    "Led",
    "Pin",
    "Rod",
    "check_end",
    "check_node",
    "check_other_body",
    "check_point",
    "check_turns",
]
