"""Description of a model: beams, sections, materials, joints and loads in SI units.

A `Scene` is a list of declarations, which `ancfsparse.system` flattens into arrays.  All input is
validated here; no motion is computed.
"""

from ancfsparse.scene.beams import Beam
from ancfsparse.scene.bodies import Body, ElasticBody, Node
from ancfsparse.scene.joints import Clamp, Connect, Joint, Pin, Rod, check_node, check_point
from ancfsparse.scene.loads import (
    ChangingGravity,
    DistributedForce,
    Load,
    PointForce,
    PointMoment,
)
from ancfsparse.scene.material import Material
from ancfsparse.scene.mesh import Mesh
from ancfsparse.scene.polygon import Polygon
from ancfsparse.scene.profiles import IBeam, Tube
from ancfsparse.scene.scene import Scene, check_scene
from ancfsparse.scene.sections import AnySection, Circle, Rectangle, Section, Taper
from ancfsparse.scene.signal import Signal
from ancfsparse.scene.signals import Pulse, Ramp, Sine, Table

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
    "Joint",
    "Load",
    "Material",
    "Mesh",
    "Node",
    "Pin",
    "PointForce",
    "PointMoment",
    "Polygon",
    "Pulse",
    "Ramp",
    "Rectangle",
    "Rod",
    "Scene",
    "Section",
    "Signal",
    "Sine",
    "Table",
    "Taper",
    "Tube",
    "check_node",
    "check_point",
    "check_scene",
]
