"""Description of a model: beams, sections, materials, joints and loads in SI units.

A `Scene` is a list of declarations, which `ancfsparse.system` flattens into arrays.  All input is
validated here; no motion is computed.
"""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand
from ancfsparse.scene.bodies.beam import Beam
from ancfsparse.scene.bodies.body import Body, Point
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.bodies.mesh import Mesh
from ancfsparse.scene.joints.clamp import Clamp
from ancfsparse.scene.joints.connect import Connect
from ancfsparse.scene.joints.distance import RigidRod
from ancfsparse.scene.joints.joint import Joint, check_node, check_point
from ancfsparse.scene.joints.pin import Pin
from ancfsparse.scene.loads.loads import (
    ChangingGravity,
    DistributedForce,
    Load,
    PointForce,
    PointMoment,
)
from ancfsparse.scene.records.signal import Signal
from ancfsparse.scene.scene import Scene, check_scene
from ancfsparse.scene.sections.cross_section import AnySection
from ancfsparse.scene.sections.material import Material
from ancfsparse.scene.sections.polygon import Polygon
from ancfsparse.scene.sections.standard_sections import Circle, IBeam, Rectangle, Section, Tube
from ancfsparse.scene.sections.taper import Taper

if TYPE_CHECKING:
    from ancfsparse.scene.records.inputs import Input
    from ancfsparse.scene.records.signals import Pulse, Ramp, Sine, Table
    from ancfsparse.scene.records.spin_up import SpinUp

__all__ = [
    "AnySection",
    "Beam",
    "Body",
    "ChangingGravity",
    "Circle",
    "Clamp",
    "Connect",
    "DistributedForce",
    "ElasticBody",
    "IBeam",
    "Input",
    "Joint",
    "Load",
    "Material",
    "Mesh",
    "Pin",
    "Point",
    "PointForce",
    "PointMoment",
    "Polygon",
    "Pulse",
    "Ramp",
    "Rectangle",
    "RigidRod",
    "Scene",
    "Section",
    "Signal",
    "Sine",
    "SpinUp",
    "Table",
    "Taper",
    "Tube",
    "check_node",
    "check_point",
    "check_scene",
]

__getattr__ = on_demand(
    __name__,
    {
        "records.inputs": "Input",
        "records.signals": "Pulse Ramp Sine Table",
        "records.spin_up": "SpinUp",
    },
)
