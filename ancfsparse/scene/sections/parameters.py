"""Stiffnesses and masses per length that follow from a section and a material."""

from __future__ import annotations

from typing import Any

from ancfsparse.scene.sections.cross_section import principal_axes
from ancfsparse.scene.sections.material import Material


def section_parameters(section: Any, material: Material) -> dict[str, dict[str, Any]]:
    """Return the parameters of the kernels, grouped by their damping.

    Parameters
    ----------
    section : CrossSection or ElementSections
        The section, or its means over elements.
    material : Material
        The material.

    Returns
    -------
    dict of str to dict
        ``"stretching"`` of the axis and the section, damped by `Material.axial_damping`;
        ``"turning"``, rotations of sections relative to each other, damped by
        `Material.bending_damping`; ``"masses"``, damped by Rayleigh's alpha; ``"ratios"``, not
        damped.  Units are those of `ElasticBody.stiffnesses`.
    """
    modulus, shear_modulus = material.youngs_modulus, material.shear_modulus
    _, inertia_y, inertia_z = principal_axes(section)
    shear_stiffness = (
        section.shear_correction(material.poisson_ratio) * shear_modulus * section.area
    )
    return {
        "stretching": {
            "axial_stiffness": modulus * section.area,
            "lame_area": material.lame_modulus * section.area,
            "shear_modulus_area": shear_modulus * section.area,
            "youngs_modulus_area": modulus * section.area,
        },
        "turning": {
            "bending_stiffness": modulus * inertia_z,
            "shear_stiffness_y": shear_stiffness,
            "shear_stiffness_z": shear_stiffness,
            "torsion_stiffness": shear_modulus * section.torsion_constant,
            "bending_stiffness_y": modulus * inertia_y,
            "bending_stiffness_z": modulus * inertia_z,
        },
        "masses": {
            "mass_per_length": material.density * section.area,
            "inertia_y": material.density * inertia_z,
            "inertia_z": material.density * inertia_y,
        },
        "ratios": {"poisson_ratio": material.poisson_ratio},
    }
