"""String: straight between its nodes, with axial strain alone, planar or spatial."""

import sympy as sp

from codegen.declarations.fields import (
    Element,
    Gauss,
    OwnParameter,
    Term,
    inner,
    interpolate,
    norm,
    parameter,
)

axial_stiffness = parameter("axial_stiffness")
mass_per_length = parameter("mass_per_length")

TRANSITION = OwnParameter("transition")
"""Strain w about which a string goes slack."""


def string(dim: int, *, slack: bool = False) -> Element:
    """U = 1/2 int EA s^2 dx, constant along the element, with s = eps = |r'| - 1.

    One that goes `slack` has s = (eps + sqrt(eps^2 + w^2)) / 2, so that its force
    N = EA s ds/deps is positive and grows with eps: it is EA (eps + w^4 / 16 eps^3 - ...) for
    eps >> w, EA w / 4 at eps = 0, and EA w^4 / 16 |eps|^3 for eps << -w.  There |r'| is
    sqrt(r'.r' + w^2), because slack elements may shrink to a point.
    """
    axes = tuple(range(dim))
    r = interpolate("r", axes, "r")
    r_x = r.diff()
    strain = norm(r_x) - 1
    if slack:
        w = TRANSITION.symbol
        strain = sp.sqrt(inner(r_x, r_x) + w**2) - 1
        strain = (strain + sp.sqrt(strain**2 + w**2)) / 2
    where = {2: "planar", 3: "spatial"}[dim]
    return Element(
        name=f"string_{where}" + "_slack" * slack,
        title=f"string, {where}: positions alone, axial part exact"
        + "; slack in compression" * slack,
        dim=dim,
        node=(("r", axes),),
        section=(),
        fields=(r, r_x),
        energy=(Term(axial_stiffness, strain, Gauss(1)),),
        inertia=((mass_per_length, r),),
        own=(TRANSITION,) * slack,
    )
