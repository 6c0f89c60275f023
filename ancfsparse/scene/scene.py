"""The scene: a list of records of what was specified, checked as they are added."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ancfsparse.errors import InputError
from ancfsparse.scene.add_bodies import Bodies
from ancfsparse.scene.add_joints import Joints
from ancfsparse.scene.add_loads import Loads
from ancfsparse.scene.digest import digest
from ancfsparse.scene.forces import Forces
from ancfsparse.scene.masses import Masses
from ancfsparse.scene.springs import Springs
from ancfsparse.words import shown


class Scene(
    Bodies,
    Joints,
    Loads,
    Masses,
    Springs,
    Forces,
):
    """Beams, joints, loads and what is attached, in one gravity field.

    Parameters
    ----------
    gravity : array_like, shape (2,) or (3,), optional
        Acceleration of gravity [m/s2].  Two components make the scene planar, three spatial.

    Attributes
    ----------
    dim : int
        2 if planar, 3 if spatial.
    gravity : ndarray, shape (dim,)
        Acceleration of gravity [m/s2], read-only.
    records : list of Spec
        What was specified, in the order of the calls.
    beams : list of Beam and Mesh
        In the order they were added.
    joints : list of Joint
        Likewise.
    loads : list of Load
        Likewise.
    attached : list of Attached
        Masses, springs and forces of the motion, likewise.
    """

    def __init__(self, gravity: ArrayLike = (0.0, -9.81)) -> None:
        super().__init__(gravity)

    def __repr__(self) -> str:
        """Count what the scene holds."""
        kind = "planar" if self.dim == 2 else "spatial"
        return (
            f"{kind} scene: beams {len(self.beams)}, joints {len(self.joints)}, "
            f"loads {len(self.loads)}" + f", attached {len(self.attached)}" * bool(self.attached)
        )

    def digest(self) -> dict[str, str]:
        """Describe its parts, so that its file can be distinguished from that of another scene."""
        return digest(self)


def check_scene(scene: object) -> None:
    """Refuse what is no scene."""
    if not isinstance(scene, Scene):
        raise InputError(f"a Scene is needed, got {shown(scene)}")
