"""The methods of a scene that add beams and meshes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ancfsparse.errors import InputError
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.scene import meshing
from ancfsparse.scene.bodies.beam import Beam, BeamSpec
from ancfsparse.scene.bodies.body import VelocityField
from ancfsparse.scene.bodies.mesh import Mesh, MeshSpec
from ancfsparse.scene.meshing.build_beam import build_beam
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.sections.cross_section import AnySection
from ancfsparse.scene.sections.material import Material

if TYPE_CHECKING:
    from ancfsparse.scene.geometry.curves import Angle, Direction
    from ancfsparse.scene.geometry.splines import AnyCurve
    from ancfsparse.scene.meshing.eigenstrain import Eigencurvature, Eigenstrain


class Bodies(SceneBase):
    """Beams and meshes of a scene."""

    def add_beam(
        self,
        element: str | ElementKind,
        start: ArrayLike | None = None,
        end: ArrayLike | None = None,
        n_elements: int | str | None = None,
        section: AnySection | None = None,
        material: Material | None = None,
        *,
        curve: AnyCurve | None = None,
        rest: str = "curved",
        nodes: ArrayLike | None = None,
        length: float | None = None,
        tension: float | None = None,
        slack: float | None = None,
        strain: str | None = None,
        curvature: str | None = None,
        section_strain: str | None = None,
        up: Direction = None,
        twist: Angle = None,
        offset: ArrayLike | None = None,
        eigenstrain: Eigenstrain = None,
        eigencurvature: Eigencurvature = None,
        velocity: ArrayLike | VelocityField | None = None,
        name: str | None = None,
    ) -> Beam:
        """Add a beam: straight and free of stress from `start` to `end`, or along a curve.

        Parameters
        ----------
        element : str or ElementKind
            ``"string"`` (positions alone: no bending stiffness), ``"l2t2"`` (planar cable),
            ``"thin"`` (cable), or ``"thick"`` (beam with section vectors, hence with
            shear and torsion); or the ``ELEMENT`` of a package built by ``ancfsparse element`` from
            a user-defined energy; or ``"auto"``: `ancf.plan` chooses it for a quantity and its
            tolerance.
        start, end : array_like, shape (dim,)
            Its two ends [m], which differ; omitted if there is a `curve`.
        n_elements : int or "auto"
            Number of elements, at least 1; ``"auto"``: `ancf.plan` chooses it.  Until then points
            such as ``rod.end`` and ``rod.at(s)`` are nodes at multiples of 1/600 of the length.
        section : AnySection
            Its cross-section, such as ``ancf.Rectangle(0.01, 0.01)``.  A spatial cable requires
            ``inertia_y`` equal to ``inertia_z``.
        material : Material
            Its material.
        curve : Arc, Helix, array_like of shape (k, dim) or callable, optional
            Its axis: a shape, points [m] through which a cubic spline runs (closed if the last is
            the first), or a function that maps parameters (k,) from 0 to 1 to positions (k, dim)
            [m].  It must be smooth; weld beams at corners.  Nodes are at equal arc lengths.
        rest : str, optional
            Stress-free shape of a beam along a curve or with a twist: ``"curved"``, that shape, or
            ``"straight"``: it is bent into that shape.  ``"curved"`` is possible for ``"thin"`` in
            a planar scene and for ``"thick"``.
        nodes : array_like, shape (n_elements + 1,), optional
            Positions of the nodes as fractions of the length, increasing from 0 to 1, in place of
            `n_elements`.
        length : float, optional
            Length without stress [m].  A beam longer than the distance of its ends starts as an
            inextensible catenary in the gravity of the scene; a shorter one, or one along a curve,
            is strained uniformly.  The stress-free beam is straight.
        tension : float, optional
            Initial axial force [N], positive in tension, in place of `length`.
        slack : float, optional
            For ``"string"``: transition strain to zero force [-], so that it transmits no
            compression.  The transition is smooth: with the axial stiffness E A the force at the
            natural length is E A slack / 4; the relative deviation from Hooke's law is
            slack^4 / (16 strain^4) in tension, and the force vanishes as fast in compression.  The
            strain under the smallest force of interest is a good choice; smaller values make steps
            harder.
        strain : str, optional
            For ``"thin"``: ``"green"``, the default, or ``"biot"``.  Strings have the strain
            ``|r'| - 1``.
        curvature : str, optional
            For ``"thick"``: ``"axis"``, the default, as in the paper, without shear in the limit of
            fine meshes; elements should be longer than about ``b**2 / R`` where a beam of height
            ``b`` bends to the radius ``R``.  ``"section"``, flexible in shear: Timoshenko's beam,
            with ``r_x`` free at clamps.  Formulas are in docs/theory.md.
        section_strain : str, optional
            For ``"thick"``: ``"consistent"``, the default, or ``"nodal"``.
        up : array_like of shape (3,) or callable, optional
            Approximate direction of e_y, the height of the section, in a spatial scene: one for the
            whole beam, or a function that maps arc lengths (k,) [m] to directions (k, 3).  By
            default the section at the start is oriented as in a planar scene: e_z as near to +z as
            possible, e_y = e_z x e_x, so a beam along +x has e_y = +y and e_z = +z, and a beam
            along z has e_y = +y.  Along a curve the frame does not rotate about e_x.  This is y of
            the section; if it has an ``inertia_yz``, the e_y and e_z of results are its principal
            axes nearest to y and z.
        twist : float or callable, optional
            Additional rotation of the section of a thick beam in space about e_x [rad], increasing
            linearly from 0 at the start to this value at the end; or a function that maps arc
            lengths (k,) [m] to angles (k,).
        offset : float or array_like of shape (dim - 1,), optional
            Offset of a straight beam of ``"thick"`` with ``curvature="section"``, from the line
            between `start` and `end` to the centroid of its section: y, in space (y, z), in the
            axes of the section [m].  ``rod.start``, ``rod.end``, ``rod.node(i)`` and ``rod.at(s)``
            are points of the line, so joints and loads there bend the beam as well;
            ``rod.at(s, y=0)`` is the centroid, along which gravity and distributed forces act.
        eigenstrain : float, callable or Signal, optional
            Axial strain without stress [-], such as a coefficient of thermal expansion times a
            change of temperature; or a function of the arc coordinate s [m], evaluated in the
            middle of every element; or a signal such as ``Ramp(1e-3, 60.0)``, uniform along the
            beam, whose work is part of the energy balance.  For ``"thin"`` in a planar scene and
            ``"thick"``.
        eigencurvature : float, array_like of shape (2,), callable or Signal, optional
            Curvature without stress [1/m], counterclockwise in the plane, about e_y and e_z in
            space: of a bimetallic strip, or by a temperature gradient.
        velocity : array_like of shape (dim,) or callable, optional
            Initial velocity [m/s]: one for all, or a function that maps reference positions
            (k, dim) [m] to velocities (k, dim).  The default is at rest.
        name : str, optional
            Name in messages; by default ``"beam 0"`` for the first beam and so on, or the next
            unused number.

        Returns
        -------
        Beam
            The handle for joints, loads and results.

        Raises
        ------
        InputError
            If an argument is invalid; the message suggests a valid one.
        """
        label = self._label(name, "beam")
        if section is None or material is None or (n_elements is None and nodes is None):
            arguments = {"n_elements": n_elements, "section": section, "material": material}
            missing = next(
                argument
                for argument, value in arguments.items()
                if value is None and (argument != "n_elements" or nodes is None)
            )
            raise InputError(f"{label} needs `{missing}`: give it to add_beam")
        record = BeamSpec(
            element=element, start=start, end=end, n_elements=n_elements, section=section,
            material=material, strain=strain, curvature=curvature, section_strain=section_strain,
            curve=curve, rest=rest, nodes=nodes, length=length, tension=tension, slack=slack,
            up=up, twist=twist, offset=offset, eigenstrain=eigenstrain,
            eigencurvature=eigencurvature, velocity=velocity, name=label,
        )  # fmt: skip
        beam = build_beam(record, self.gravity)
        return self._take(beam, record.checked(beam))

    def add_mesh(
        self,
        nodes: ArrayLike,
        edges: ArrayLike,
        element: str | ElementKind,
        section: AnySection,
        material: Material,
        *,
        n_elements: int | str = 1,
        smooth: float = 5.0,
        slack: float | None = None,
        strain: str | None = None,
        curvature: str | None = None,
        section_strain: str | None = None,
        velocity: ArrayLike | VelocityField | None = None,
        name: str | None = None,
    ) -> Mesh:
        """Add a net or lattice of cables or beams along the edges between nodes.

        All edges at a node share its position.  Edges that continue each other in a line also share
        their slope and section, as the elements of one cable or beam do; all others rotate
        independently.  `add_frame` welds them instead.

        Parameters
        ----------
        nodes : array_like, shape (n, dim)
            Positions of the nodes [m], each of them at the end of some edge.
        edges : array_like of int, shape (m, 2)
            The two nodes of every edge, numbered from 0.
        element : str or ElementKind
            ``"string"`` (no bending stiffness, three coordinates a node in space), ``"l2t2"``
            (planar cable), ``"thin"`` (cable) or ``"thick"`` (beam), or a user element, as
            in `add_beam`; or ``"auto"``: `ancf.plan` chooses strings or cables.  In space a line of
            ``"thick"`` with hinges at both ends may rotate about its axis; its sections have e_z as
            near to +z as possible, as in `add_beam`.
        section : AnySection
            Cross-section of all edges, as in `add_beam`; it must be uniform.  A spatial cable needs
            ``inertia_y`` equal to ``inertia_z``.
        material : Material
            Their material.
        n_elements : int or "auto", optional
            Number of elements of every edge, at least 1.  Nodes inside edges are numbered after
            those given.  ``"auto"``: `ancf.plan` chooses it; until then handles are the nodes that
            were given, and points inside edges.
        smooth : float, optional
            Largest angle between edges that continue each other as one cable [degrees], 0 to 90.
            Of several edges the straightest two are connected first, and an edge is continued at
            most once at each end.  The shared slope is the mean of both directions, so a cable with
            a bend starts with the stress of that bend.
        slack, strain, curvature, section_strain, velocity : optional
            As in `add_beam`.
        name : str, optional
            Name in messages; by default ``"mesh 0"`` for the first body and so on.

        Returns
        -------
        Mesh
            The handle for joints, loads and results.

        Raises
        ------
        InputError
            If an argument is invalid; the message names the first offender and their number.
        """
        record = MeshSpec(
            nodes=nodes, edges=edges, element=element, section=section, material=material,
            n_elements=n_elements, smooth=smooth, slack=slack, strain=strain, curvature=curvature,
            section_strain=section_strain, velocity=velocity, name=self._label(name, "mesh"),
        )  # fmt: skip
        mesh = meshing.build_mesh(record, self.dim)
        return self._take(mesh, record.checked(mesh))
