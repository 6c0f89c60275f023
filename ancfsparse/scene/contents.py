"""The beams and meshes of a scene, checked as they are added."""

from __future__ import annotations

import itertools
import math
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import check_vector
from ancfsparse.errors import InputError
from ancfsparse.scene.attached import Attached
from ancfsparse.scene.beams import Beam
from ancfsparse.scene.bodies import Body, VelocityField
from ancfsparse.scene.edges_to_cables import mesh_of
from ancfsparse.scene.material import Material
from ancfsparse.scene.mesh import Mesh
from ancfsparse.scene.sections import AnySection
from ancfsparse.scene.straight import straight_beam
from ancfsparse.words import shown

Thing = TypeVar("Thing", bound=Attached)


class Contents:
    """Beams and meshes in one gravity field; `Scene` adds joints and loads.

    Parameters
    ----------
    gravity : array_like, shape (2,) or (3,)
        Acceleration of gravity [m/s2].  Two components make the scene planar, three spatial.
    """

    def __init__(self, gravity: ArrayLike) -> None:
        try:
            size = np.shape(gravity)
        except ValueError:  # rows that differ
            size = ()
        if size not in ((2,), (3,)):
            raise InputError(
                "gravity must have 2 components (planar scene) or 3 (spatial), got "
                f"{shown(gravity)}"
            )
        self.dim: int = size[0]
        self.gravity: NDArray[np.float64] = check_vector("gravity", gravity, self.dim, "m/s2")
        self.beams: list[Body] = []
        self.attached: list[Attached] = []
        self._names: set[str] = set()
        self._handles: set[Body] = set()

    def add_beam(
        self,
        element: str,
        start: ArrayLike,
        end: ArrayLike,
        n_elements: int,
        section: AnySection,
        material: Material,
        *,
        strain: str = "green",
        curvature: str = "axis",
        section_strain: str = "consistent",
        up: ArrayLike | None = None,
        velocity: ArrayLike | VelocityField | None = None,
        name: str | None = None,
    ) -> Beam:
        """Add a beam, straight and free of stress from `start` to `end`.

        Parameters
        ----------
        element : str
            ``"l2t2"`` (planar cable), ``"thin"`` (cable), or ``"thick"`` (beam with section
            vectors, so with shear and torsion).
        start, end : array_like, shape (dim,)
            Its two ends [m], apart from each other.
        n_elements : int
            Number of elements, at least 1.
        section : Rectangle, Circle or Section
            Its cross-section.  A spatial cable bends alike in all directions and needs
            ``inertia_y`` equal to ``inertia_z``.
        material : Material
            What it is made of.
        strain : str, optional
            For ``"thin"``: ``"green"`` or ``"biot"``.
        curvature : str, optional
            For ``"thick"``: ``"axis"``, the paper's, without shear in the limit of fine meshes;
            elements should stay longer than about ``b**2 / R`` where a beam of height ``b`` bends
            to the radius ``R``.  ``"section"``, flexible in shear: Timoshenko's beam, with
            ``r_x`` free at clamps.  Formulas are in docs/theory.md.
        section_strain : str, optional
            For ``"thick"``: ``"consistent"`` or ``"nodal"``.
        up : array_like, shape (3,), optional
            Rough direction of e_y, the height of the section, in a spatial scene.  The default
            turns the section as in a planar scene: e_z as near to +z as possible,
            e_y = e_z x e_x, so a beam along +x has e_y = +y and e_z = +z.  A beam along z
            takes e_y = +y.
        velocity : array_like of shape (dim,) or callable, optional
            Initial velocity [m/s]: one for all, or a function that maps reference positions
            (k, dim) [m] to velocities (k, dim).  The default is at rest.
        name : str, optional
            How messages call it; ``"beam 0"`` for the first beam and so on if not given, or the
            next number that no name has.

        Returns
        -------
        Beam
            The handle for joints, loads and results.

        Raises
        ------
        InputError
            If anything does not fit, with what to give instead.
        """
        label = self._label(name, "beam")
        given = {"strain": strain, "curvature": curvature, "section_strain": section_strain}
        beam = straight_beam(
            label, self.dim, element, start, end, n_elements, section, material, given, up, velocity
        )
        self._take(beam)
        return beam

    def add_mesh(
        self,
        nodes: ArrayLike,
        edges: ArrayLike,
        element: str,
        section: AnySection,
        material: Material,
        *,
        smooth: float = 5.0,
        strain: str = "green",
        velocity: ArrayLike | VelocityField | None = None,
        name: str | None = None,
    ) -> Mesh:
        """Add a net or lattice of cables: one element for each edge between two nodes.

        All edges at a node share its position.  Edges that run on through it in a line share
        their slope, as the elements of one cable do; all others are free to turn against each
        other.

        Parameters
        ----------
        nodes : array_like, shape (n, dim)
            Positions of the nodes [m], each of them at the end of some edge.
        edges : array_like of int, shape (m, 2)
            The two nodes of every edge, numbered from 0.
        element : str
            ``"l2t2"`` (planar cable) or ``"thin"`` (cable).
        section : Rectangle, Circle or Section
            Cross-section of all edges.  A spatial cable needs ``inertia_y`` equal to
            ``inertia_z``.
        material : Material
            What they are made of.
        smooth : float, optional
            Edges that deviate by less than this from running on straight make one cable
            [degrees], 0 to 90.  Where several could, the straightest two are taken first, and an
            edge is continued at most once at each end.  The shared slope is the mean of both
            directions, so a cable with a bend starts with the stress of that bend.
        strain : str, optional
            For ``"thin"``: ``"green"`` or ``"biot"``.
        velocity : array_like of shape (dim,) or callable, optional
            Initial velocity [m/s]: one for all, or a function that maps reference positions
            (k, dim) [m] to velocities (k, dim).  The default is at rest.
        name : str, optional
            How messages call it; ``"mesh 0"`` if it is the first in the scene and so on.

        Returns
        -------
        Mesh
            The handle for joints, loads and results.

        Raises
        ------
        InputError
            If anything does not fit, with the first offender and how many there are.
        """
        label = self._label(name, "mesh")
        given = {"strain": strain}
        mesh = mesh_of(
            label, self.dim, nodes, edges, element, section, material, given, smooth, velocity
        )
        self._take(mesh)
        return mesh

    def _take(self, body: Body) -> None:
        for name, value in (*body.stiffnesses().items(), *body.viscosities().items()):
            if not math.isfinite(value):
                raise InputError(
                    f"{name} of {body.name} is {value:g}, beyond the range of floating-point "
                    "numbers: check the units of its section and its material"
                )
        self.beams.append(body)
        self._names.add(body.name)
        self._handles.add(body)

    def _attach(self, thing: Thing) -> Thing:
        self.attached.append(thing)
        return thing

    def _label(self, name: str | None, kind: str) -> str:
        free = (f"{kind} {i}" for i in itertools.count(len(self.beams)))
        label = next(each for each in free if each not in self._names) if name is None else name
        if not isinstance(label, str) or not label.strip():
            raise InputError(
                f"the name of a {kind} must be a text that is not empty, got {shown(name)}"
            )
        if label in self._names:
            raise InputError(f"the scene already has a beam named {label!r}: give another name")
        return label

    def _own(self, what: str, body: Body) -> Body:
        if body not in self._handles:
            raise InputError(
                f"{what} was given {body.name} of another scene: use a handle that add_beam or "
                "add_mesh of this scene returned"
            )
        return body
