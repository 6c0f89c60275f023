"""The scene: a list of records, checked when they are added."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar

from numpy.typing import ArrayLike

from ancfsparse.errors import InputError
from ancfsparse.messages import format_numbers, format_value
from ancfsparse.scene import storage
from ancfsparse.scene.force_elements.contacts import Contacts
from ancfsparse.scene.force_elements.joint_springs import JointSprings
from ancfsparse.scene.force_elements.masses import Masses
from ancfsparse.scene.force_elements.ropes import Ropes
from ancfsparse.scene.force_elements.springs import Springs
from ancfsparse.scene.force_elements.user_forces import Forces
from ancfsparse.scene.methods.add_couplings import Couplings
from ancfsparse.scene.methods.add_frames import Frames
from ancfsparse.scene.methods.add_joints import Joints
from ancfsparse.scene.methods.add_loads import Loads
from ancfsparse.scene.methods.add_rigid_bodies import RigidBodies
from ancfsparse.scene.records.record import equal
from ancfsparse.scene.storage.digest import digest


class Scene(
    Frames,
    RigidBodies,
    Joints,
    Couplings,
    Loads,
    Masses,
    Springs,
    Ropes,
    JointSprings,
    Forces,
    Contacts,
):
    """Beams, rigid bodies, joints, loads and attachments in one gravity field.

    Its methods that add something return a handle of it, of the class that their signature names.

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
    records : tuple of Record
        Records of the calls, in their order.
    bodies : list of Beam, Mesh and RigidBody
        In the order they were added.
    beams : list of Beam and Mesh
        Bodies made of elements, likewise.
    joints : list of Joint
        Likewise.
    loads : list of Load
        Likewise.
    attachments : list of Attachment
        Masses, springs and forces, likewise.
    """

    def __init__(self, gravity: ArrayLike = (0.0, -9.81)) -> None:
        super().__init__(gravity)

    show: ClassVar[Callable[[Scene], str | None]] = lambda scene: None
    """Draws a scene for a notebook, set by `ancfsparse.results`."""

    def _repr_html_(self) -> str | None:
        """Return a picture for a notebook, which can be turned; None if it cannot be drawn."""
        return self.show()

    def __repr__(self) -> str:
        """Return the numbers of its parts."""
        kind = "planar" if self.dim == 2 else "spatial"
        return (
            f"{kind} scene: beams {len(self.beams)}, "
            + f"rigid bodies {len(self.bodies) - len(self.beams)}, " * (self.bodies != self.beams)
            + f"joints {len(self.joints)}, "
            f"loads {len(self.loads)}"
            + f", attached {len(self.attachments)}"
            * bool(self.attachments)
        )

    def __str__(self) -> str:
        """Return the records as text, a line for each call, and notes on contacts."""
        kind = "planar" if self.dim == 2 else "spatial"
        first = f"{kind} scene, gravity {format_numbers(self.gravity)} m/s2"
        notes = [note for each in self.attachments for note in each.notes(self.joints)]
        records = (storage.format_record(record, self) for record in self.records)
        return "\n".join([first, *records, *notes])

    def __eq__(self, other: object) -> bool:
        """Return True if the records are equal; functions are equal if they are identical."""
        if not isinstance(other, Scene):
            return NotImplemented
        return equal(self.gravity, other.gravity) and self.records == other.records

    __hash__ = None  # type: ignore[assignment]

    def __copy__(self) -> Scene:
        """Return a copy built from the same records, independent of this scene."""
        return self.replaced()

    def digest(self) -> dict[str, str]:
        """Return descriptions of its parts, which distinguish the files of different scenes."""
        return digest(self)

    def save(self, path: str | Path) -> None:
        """Write the scene to a JSON or TOML file, from which `Scene.load` rebuilds it.

        JSON has a line for each call, with all arguments by name in SI units; TOML has a table for
        each call, with the arguments that are not defaults and names in place of references, as
        users write it.  Arrays of more than 1000 numbers are in base64.  Every number is restored
        to the last bit.  Functions and elements of your own are stored by name, such as
        ``"module.gust"``.

        Parameters
        ----------
        path : str or Path
            The file, such as ``"scene.json"`` or ``"scene.toml"``; an older one is replaced, but
            not results of a run.

        Raises
        ------
        InputError
            If a function is compiled, two functions have one name, the name does not end in
            ``.json`` or ``.toml``, or nothing can be written there.
        """
        storage.save(self, path)

    @classmethod
    def load(cls, path: str | Path, own: Mapping[str, Any] | None = None) -> Scene:
        """Build the scene of a file, which `save` or a user wrote.

        Parameters
        ----------
        path : str or Path
            The file, TOML if its name ends in ``.toml``, else JSON; docs/scene-files.md describes
            it.  Settings of a run in it are read by the command ``ancfsparse run``.
        own : dict of str to object, optional
            Functions and elements of your own, under the names in the file.  Loading a file imports
            and calls nothing else.

        Returns
        -------
        Scene
            The scene, equal to the one that was saved.

        Raises
        ------
        InputError
            If the file is not valid, needs a function that is missing, or has an invalid call; the
            message gives the number of the record, or the line and the keys.
        """
        return storage.load(cls, path, {} if own is None else own)

    def refined(self, factor: int = 2) -> Scene:
        """Return a copy with every element divided into `factor` elements of equal length.

        Joints, loads and attached parts keep their positions.  Of a mesh every edge is divided;
        a bend between two edges stays at its node.

        Parameters
        ----------
        factor : int, optional
            Number of elements in place of one, at least 1.

        Returns
        -------
        Scene
            The copy; `counterpart` gives its handles.
        """
        return storage.refined(self, factor)

    def replaced(
        self, handle: object = None, /, *, gravity: ArrayLike | None = None, **changes: Any
    ) -> Scene:
        """Return a copy with other arguments in one call, such as another material.

        Points keep their positions if a beam gets another number of elements.

        Parameters
        ----------
        handle : object, optional
            Return value of the call: a beam, mesh, joint, load, mass, spring or force.
        gravity : array_like, shape (dim,), optional
            Another acceleration of gravity [m/s2].
        **changes
            Other arguments of the method, by name.

        Returns
        -------
        Scene
            The copy; `counterpart` gives its handles.

        Raises
        ------
        InputError
            If the handle is of another scene, the method has no such argument, or the copy would
            be invalid.

        Examples
        --------
        >>> stiffer = scene.replaced(rod, material=ancf.Material(2e8, 4000))
        >>> on_the_moon = scene.replaced(gravity=(0.0, -1.62))
        """
        return storage.replaced(self, handle, gravity, changes)

    def counterpart(self, handle: Any) -> Any:
        """Return the handle in this scene for a beam, a mesh or a point of another one.

        Parameters
        ----------
        handle : Beam, Mesh or Point
            A handle in another scene, on a body of the same name.

        Returns
        -------
        Beam, Mesh or Point
            The body of that name, or the same point of it.

        Raises
        ------
        InputError
            If there is no body of that name.
        """
        return storage.counterpart(self, handle)


def check_scene(scene: object) -> None:
    """Refuse an object that is not a scene."""
    if not isinstance(scene, Scene):
        raise InputError(f"a Scene is needed, got {format_value(scene)}")
