"""Thick beam with nodal vectors r, r_x, r_y, r_z: elastic line approach of Schwab and Meijaard."""

from collections.abc import Callable

import sympy as sp

from codegen.declarations.fields import (
    Element,
    Field,
    Gauss,
    Legendre,
    Nodal,
    Rule,
    Term,
    interpolate,
    parameter,
)
from codegen.declarations.kernels import NAMES

lame_area = parameter("lame_area")
shear_modulus_area = parameter("shear_modulus_area")
youngs_modulus_area = parameter("youngs_modulus_area")
poisson_ratio = parameter("poisson_ratio")
shear_stiffness_y = parameter("shear_stiffness_y")
shear_stiffness_z = parameter("shear_stiffness_z")
torsion_stiffness = parameter("torsion_stiffness")
bending_stiffness_y = parameter("bending_stiffness_y")
bending_stiffness_z = parameter("bending_stiffness_z")
mass_per_length = parameter("mass_per_length")
inertia_y = parameter("inertia_y")
inertia_z = parameter("inertia_z")

eps_x, eps_y, eps_z, eps_l = sp.symbols("eps_x eps_y eps_z eps_l")


def thick(
    dim: int,
    curvature: str,
    section_strain: str,
    *,
    by_quadrature: bool = False,
    curved: bool = False,
) -> Element:
    """U = W_l + W_s + W_t + W_b; in the plane r_z has only its out-of-plane component.

    With curvature "axis" the two modes of shear leave bending free of it, and r_x turns with the
    section.  With "section" shear is all of r_x.r_y and r_x.r_z: what two modes do not see of r_x,
    a wave within the element, would cost nothing.  There r_x is free to leave the section.

    `by_quadrature` integrates the same energy with as many Gauss points as each term requires to be
    exact: slower, for comparison only.  If `curved`, the strains of the reference shape are
    subtracted.
    """
    axes, across = ((0, 1), (2,)) if dim == 2 else ((0, 1, 2), (0, 1, 2))
    r = interpolate("r", axes, "r", "r_x")
    r_x = r.diff()
    r_xx = r_x.diff()
    r_y = interpolate("r_y", axes, "r_y")
    r_z = interpolate("r_z", across, "r_z")
    r_yx, r_zx = r_y.diff(), r_z.diff()

    def exact(points: int, modes: int | None = None) -> Rule:
        return Gauss(points, modes) if by_quadrature else Legendre(modes)

    change: tuple[Term, ...] = ()
    section: tuple[str, ...] = ("r_x", "r_y", "r_z")
    if curvature == "axis":
        kap_y, kap_z = r_z @ r_xx, -(r_y @ r_xx)
        shear = exact(3, modes=2)
    else:
        kap_y, kap_z = -(r_x @ r_zx), r_x @ r_yx
        shear, change = exact(4), _change_of_section(r_y, r_z, exact(1, modes=1))
        section = section[1:]
    kap_x = (r_z @ r_yx - r_y @ r_zx) / 2
    energy = (
        *_section_and_axis(section_strain, r_y @ r_z, exact),
        Term(shear_stiffness_y, r_x @ r_y, shear),
        Term(shear_stiffness_z, r_x @ r_z, shear),
        Term(torsion_stiffness, kap_x, exact(1)),
        Term(bending_stiffness_y, kap_y, exact(3)),
        Term(bending_stiffness_z, kap_z, exact(3)),
        *change,
    )
    plane = "planar_" if dim == 2 else ""
    where = {2: "planar", 3: "spatial"}[dim]
    how = "by exact Gauss quadrature, reference only" if by_quadrature else "in closed form"
    return Element(
        name=f"thick_{plane}{curvature}_{section_strain}"
        + "_gauss" * by_quadrature
        + "_curved" * curved,
        title=f"thick beam, {where}, {curvature} curvature, {section_strain} section strain; {how}"
        + "; curved where free of strain" * curved,
        dim=dim,
        node=(("r", axes), ("r_x", axes), ("r_y", axes), ("r_z", across)),
        section=section,
        fields=(r_x, r_xx, r_y, r_yx, r_z, r_zx),
        strains=((eps_x, _green(r_x)), (eps_y, _green(r_y)), (eps_z, _green(r_z))),
        projected=((eps_l, eps_x),),
        energy=tuple(term for term in energy if term.strain != 0),
        inertia=((mass_per_length, r), (inertia_y, r_y), (inertia_z, r_z)),
        kernels=("energy", "force") if by_quadrature else NAMES,
        curved=curved,
    )


def _green(u: Field) -> sp.Expr:
    return (u @ u - 1) / 2


def _section_and_axis(
    section_strain: str, gamma_yz: sp.Expr, exact: Callable[[int], Rule]
) -> tuple[Term, ...]:
    """W_l, either as published or rearranged for a section free of stress.

    lam (eps_x + eps_y + eps_z)^2 + 2G (eps_x^2 + eps_y^2 + eps_z^2)
      = E eps_x^2 + (lam + G) (eps_y + eps_z + 2 nu eps_x)^2 + G (eps_y - eps_z)^2.

    Section vectors are interpolated linearly, so they shorten between nodes that are rotated
    against each other, and the last two brackets cannot vanish; evaluated at the nodes only, they
    can, and the beam does not lock.  At the nodes eps_x is replaced by its projection on linear
    functions: otherwise an oscillation of eps_x within the element would affect the nodal values
    only and lower the energy on every mesh.
    """
    if section_strain == "consistent":
        return (
            Term(lame_area, eps_x + eps_y + eps_z, exact(5)),
            *(Term(2 * shear_modulus_area, eps, exact(5)) for eps in (eps_x, eps_y, eps_z)),
            Term(shear_modulus_area, gamma_yz, exact(3)),
        )
    across = eps_y + eps_z + 2 * poisson_ratio * eps_l
    return (
        Term(youngs_modulus_area, eps_x, exact(5)),
        Term(lame_area + shear_modulus_area, across, Nodal()),
        Term(shear_modulus_area, eps_y - eps_z, Nodal()),
        Term(shear_modulus_area, gamma_yz, Nodal()),
    )


def _change_of_section(r_y: Field, r_z: Field, mean: Rule) -> tuple[Term, ...]:
    """Shear over the section due to the derivatives of the section vectors along the beam.

    At a point y r_y + z r_z off the axis, r_x changes by y r_yx + z r_zx.  Its products with r_y
    and r_z, squared and integrated over the section, give these terms in addition to torsion.  One
    mode each: more would prevent the section from shortening between nodes rotated against each
    other.
    """
    g_y, g_z = (ei / (2 * (1 + poisson_ratio)) for ei in (bending_stiffness_y, bending_stiffness_z))
    r_yx, r_zx = r_y.diff(), r_z.diff()
    return (
        Term(g_z, r_y @ r_yx, mean),
        Term(g_y, r_z @ r_zx, mean),
        Term((g_y + g_z) / 4, r_y @ r_zx + r_z @ r_yx, mean),
    )
