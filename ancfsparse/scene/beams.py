"""Beams and the points on them, as handles that joints, loads and results are asked with."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, check_finite
from ancfsparse.scene.material import Material
from ancfsparse.scene.sections import AnySection

VelocityField = Callable[[NDArray[np.float64]], NDArray[np.float64]]


# A point closer to a node than this share of an element is that node: rounding, not a place.
NODE_SNAP = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class Beam:
    """A straight beam in a scene, as `Scene.add_beam` returns it.

    Two beams are equal only if they are the same one.

    Attributes
    ----------
    name : str
        Unique in its scene.
    element : str
        ``"l2t2"``, ``"thin"`` or ``"thick"``.
    options : dict of str to str
        The options this element has, and no others.
    section : Rectangle, Circle or Section
        Its cross-section.
    material : Material
        What it is made of.
    n_elements : int
        Number of elements, all of one length.
    positions : ndarray, shape (n_nodes, dim)
        Reference positions of the nodes [m], read-only.
    axes : ndarray, shape (dim, dim)
        Rows are the unit vectors e_x (along the beam), e_y and, in a spatial scene, e_z of the
        section in the reference shape, read-only.
    velocity : callable or None
        Initial velocities: maps reference places (k, dim) [m] to velocities (k, dim) [m/s].
        None means at rest.
    """

    name: str
    element: str
    options: Mapping[str, str]
    section: AnySection
    material: Material
    n_elements: int
    positions: NDArray[np.float64]
    axes: NDArray[np.float64]
    velocity: VelocityField | None = None

    def __repr__(self) -> str:
        """Say which beam this is."""
        return (
            f"{self.name}: {self.n_elements} {self.element} elements, {self.length:.6g} m, "
            f"{'planar' if self.dim == 2 else 'spatial'}"
        )

    @property
    def dim(self) -> int:
        """Number of components of a position, 2 or 3."""
        return int(self.positions.shape[1])

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return self.n_elements + 1

    @property
    def length(self) -> float:
        """Length in the reference shape [m]."""
        return float(np.linalg.norm(self.positions[-1] - self.positions[0]))

    @property
    def start(self) -> Node:
        """The first node."""
        return Node(self, 0)

    @property
    def end(self) -> Node:
        """The last node."""
        return Node(self, self.n_elements)

    def node(self, i: int) -> Node:
        """Return one of the nodes.

        Parameters
        ----------
        i : int
            Number of the node, 0 at the start to ``n_elements`` at the end.

        Returns
        -------
        Node
            Its handle.
        """
        if isinstance(i, bool) or not isinstance(i, (int, np.integer)):
            raise InputError(f"the number of a node of {self.name} must be an integer, got {i!r}")
        if not 0 <= i <= self.n_elements:
            raise InputError(
                f"{self.name} has nodes 0 to {self.n_elements}, there is no node {i}"
                + ("; its last one is `.end`" if i < 0 else "")
            )
        return Node(self, int(i))

    def at(self, s: float) -> Node:
        """Return the point at an arc coordinate of the reference shape.

        Parameters
        ----------
        s : float
            Distance from the start along the undeformed axis [m], 0 to ``length``.

        Returns
        -------
        Node
            A node where `s` falls on one (to rounding), else a point inside an element.
        """
        distance = check_finite(f"arc coordinate s on {self.name}", s, "m")
        share = distance / self.length * self.n_elements
        nearest = round(share)
        if abs(share - nearest) <= NODE_SNAP and 0 <= nearest <= self.n_elements:
            return Node(self, nearest)
        if not 0.0 < share < self.n_elements:
            raise InputError(
                f"arc coordinate s = {distance:.6g} m lies outside {self.name}: "
                f"it runs from 0 to {self.length:.6g} m"
            )
        return Node(self, int(share), share - int(share))

    def parameters(self) -> dict[str, float]:
        """Give the base parameters of the kernels, the same for every element of the beam.

        Returns
        -------
        dict of str to float
            ``length`` of one element [m]; ``axial_stiffness`` = ``youngs_modulus_area`` E A,
            ``shear_modulus_area`` G A, ``lame_area`` lam A, ``shear_stiffness_y`` and ``_z``
            k G A [N]; ``torsion_stiffness`` G J, ``bending_stiffness_y`` E int z^2 dA,
            ``bending_stiffness_z`` = ``bending_stiffness`` E int y^2 dA [N m2];
            ``mass_per_length`` rho A [kg/m]; ``inertia_y`` rho int y^2 dA and ``inertia_z``
            rho int z^2 dA [kg m]; ``poisson_ratio``.

        Notes
        -----
        ``inertia_y`` goes with the section vector r_y and so holds int y^2 dA, which as a second
        moment of area is named after the axis it turns about: ``section.inertia_z``.
        """
        section, material = self.section, self.material
        modulus, shear_modulus = material.youngs_modulus, material.shear_modulus
        shear_stiffness = (
            section.shear_correction(material.poisson_ratio) * shear_modulus * section.area
        )
        return {
            "length": self.length / self.n_elements,
            "axial_stiffness": modulus * section.area,
            "bending_stiffness": modulus * section.inertia_z,
            "mass_per_length": material.density * section.area,
            "lame_area": material.lame_modulus * section.area,
            "shear_modulus_area": shear_modulus * section.area,
            "youngs_modulus_area": modulus * section.area,
            "poisson_ratio": material.poisson_ratio,
            "shear_stiffness_y": shear_stiffness,
            "shear_stiffness_z": shear_stiffness,
            "torsion_stiffness": shear_modulus * section.torsion_constant,
            "bending_stiffness_y": modulus * section.inertia_y,
            "bending_stiffness_z": modulus * section.inertia_z,
            "inertia_y": material.density * section.inertia_z,
            "inertia_z": material.density * section.inertia_y,
        }


@dataclass(frozen=True, repr=False)
class Node:
    """A point on a beam.

    Parameters
    ----------
    beam : Beam
        The beam it is on.
    index : int
        Number of the node if `xi` is 0, else of the element the point is inside of.
    xi : float, optional
        Share of the element's length, in (0, 1) inside an element, 0 at a node.
    """

    beam: Beam
    index: int
    xi: float = 0.0

    def __repr__(self) -> str:
        """Say where the point is."""
        return f"{self.beam.name} at s = {self.s:.6g} m"

    @property
    def is_node(self) -> bool:
        """Whether the point is a node of the mesh."""
        return self.xi == 0.0

    @property
    def s(self) -> float:
        """Arc coordinate in the reference shape [m]."""
        return (self.index + self.xi) / self.beam.n_elements * self.beam.length

    @property
    def position(self) -> NDArray[np.float64]:
        """Position in the reference shape, shape (dim,) [m]."""
        nodes = self.beam.positions
        after = min(self.index + 1, self.beam.n_elements)
        return np.asarray((1.0 - self.xi) * nodes[self.index] + self.xi * nodes[after])
