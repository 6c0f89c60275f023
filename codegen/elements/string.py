"""String: straight between its nodes, with axial strain alone, planar or spatial."""

from codegen.fields import Element, Gauss, Term, interpolate, norm, parameter

axial_stiffness = parameter("axial_stiffness")
mass_per_length = parameter("mass_per_length")


def string(dim: int) -> Element:
    """U = 1/2 int EA eps^2 dx with eps = |r'| - 1, which is constant along the element."""
    axes = tuple(range(dim))
    r = interpolate("r", axes, "r")
    r_x = r.diff()
    where = {2: "planar", 3: "spatial"}[dim]
    return Element(
        name=f"string_{where}",
        title=f"string, {where}: positions alone, axial part exact",
        dim=dim,
        node=(("r", axes),),
        section=(),
        fields=(r, r_x),
        energy=(Term(axial_stiffness, norm(r_x) - 1, Gauss(1)),),
        inertia=((mass_per_length, r),),
    )
