"""Bodies made of elements: beams and meshes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.messages import checksum
from ancfsparse.scene.bodies.body import Body
from ancfsparse.scene.sections.cross_section import AnySection
from ancfsparse.scene.sections.material import Material
from ancfsparse.scene.sections.parameters import section_parameters

if TYPE_CHECKING:
    from ancfsparse.scene.records.plane import Plane


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ElasticBody(Body):
    """Elements of one type, section and material.

    Attributes
    ----------
    section : AnySection
        Cross-section.
    material : Material
        Material.
    """

    section: AnySection
    material: Material

    def finer(self, times: int) -> dict[str, Any]:
        """Return the arguments that change if every element is divided."""
        if "n_elements" in self.automatic:
            raise InputError(
                f"{self.name} has n_elements='auto', which a plan chooses: nothing can be refined"
            )
        return {"n_elements": times * self.n_each}

    def planar_arguments(self, record: Any, plane: Plane) -> dict[str, Any]:
        """Return the arguments of a record that change in a planar scene."""
        if not isinstance(record.element, str):
            plane.refuse()
        plane.put(self.positions)
        velocity = record.velocity
        if callable(velocity) and self.velocity is not None:
            here = plane.into(self.velocity(self.positions))
            if self.kind.section[1:]:  # sections extend out of the plane
                off_plane = plane.into(self.velocity(self.positions + self.shortest * plane.normal))
                plane.check(np.abs(off_plane - here).max(), np.abs(here).max())
        return {"velocity": plane.project(velocity, "into", of_positions=True)}

    def describe(self) -> dict[str, str]:
        """Describe element, section, material and mesh."""
        links = np.concatenate([self.row_nodes, self.ends.ravel()]).astype("<i4")
        return {
            "element": repr(self.kind)
            if self.kind.package or self.kind.values
            else " ".join([self.element, *self.options.values()]),
            "section": repr(self.section),
            "material": repr(self.material),
            "mesh": f"{self.n_elements} elements, {checksum(links.tobytes())}",
        }

    def free_of_stress(self, ends: Vector) -> Vector:
        """Return the stress-free coordinates of both nodes of every element, (n, 2, n_c).

        `ends` are the coordinates in the reference shape; eigenstrains make them differ.
        """
        return ends

    branches = False  # True if several edges may meet at its nodes

    @property
    def directions(self) -> Vector:
        """1 for every element, or -1 if it was reversed, (n_elements,)."""
        return np.ones(self.n_elements)

    @property
    def masses_per_length(self) -> Vector:
        """Mass per length of every element, (n_elements,) [kg/m]."""
        return np.broadcast_to(self.stiffnesses()["mass_per_length"], self.n_elements)

    @property
    def total_mass(self) -> float:
        """Mass of its elements [kg]."""
        return float(self.masses_per_length @ self.lengths)

    @property
    def speed(self) -> float:
        """Speed of sound in its material [m/s]."""
        return math.sqrt(self.material.youngs_modulus / self.material.density)

    def stiffnesses(self) -> dict[str, float]:
        """Return the parameters of the kernels that all elements have in common.

        Returns
        -------
        dict of str to float
            ``axial_stiffness`` = ``youngs_modulus_area`` E A,
            ``shear_modulus_area`` G A, ``lame_area`` lam A, ``shear_stiffness_y`` and ``_z``
            k G A [N]; ``torsion_stiffness`` G J, ``bending_stiffness_y`` E int z^2 dA,
            ``bending_stiffness_z`` = ``bending_stiffness`` E int y^2 dA [N m2];
            ``mass_per_length`` rho A [kg/m]; ``inertia_y`` rho int y^2 dA and ``inertia_z``
            rho int z^2 dA [kg m]; ``poisson_ratio``.

        Notes
        -----
        ``inertia_y`` goes with the section vector r_y and so holds int y^2 dA, which as a second
        moment of area is named after the axis of rotation: ``section.inertia_z``.
        """
        return {
            name: value for group in self._parameters().values() for name, value in group.items()
        }

    @property
    def profile(self) -> Any:
        """Section, or its means over elements if it changes."""
        return self.section

    @property
    def strains_damped(self) -> bool:
        """True if the rates of its strains are damped."""
        return self.material.axial_retardation > 0.0 or self.material.bending_retardation > 0.0

    @property
    def masses_damped(self) -> bool:
        """True if its velocity in space is damped."""
        return self.material.rayleigh[0] > 0.0

    def viscosities(self) -> dict[str, float]:
        """Return the parameters of the kernels for damping, in place of `stiffnesses`.

        Returns
        -------
        dict of str to float
            The stiffnesses times retardation times, the masses times Rayleigh's alpha, and
            ``poisson_ratio`` as it is.
        """
        material = self.material
        factors = {
            "stretching": material.axial_retardation,
            "turning": material.bending_retardation,
            "masses": material.rayleigh[0],
            "ratios": 1.0,
        }
        return {
            name: factors[kind] * value
            for kind, group in self._parameters().items()
            for name, value in group.items()
        }

    def _parameters(self) -> dict[str, dict[str, float]]:
        """Return all parameters, of user elements too, grouped by their damping."""
        groups = section_parameters(self.profile, self.material)
        for name, group in self.kind.own.items():
            groups[group][name] = self.kind.values[name]
        return groups
