"""Thin cable of Gerstmayr and Shabana (2006): exact curvature, planar or spatial."""

from codegen.declarations.fields import (
    Element,
    Gauss,
    Term,
    cross,
    inner,
    interpolate,
    norm,
    parameter,
)

axial_stiffness = parameter("axial_stiffness")
bending_stiffness = parameter("bending_stiffness")
mass_per_length = parameter("mass_per_length")


def thin(dim: int, strain: str, *, curved: bool = False) -> Element:
    """U = 1/2 int EA eps^2 dx + 1/2 int EI kappa.kappa dx.

    green  eps = (r'.r' - 1)/2, exact;  kappa = r' x r'' / |r'|^3 at 3 Gauss points
    biot   eps = |r'| - 1 at 5 points;  kappa = r' x r'' / |r'|^2 at 3 Gauss points

    Of a `curved` one, in the plane, both are less those of its reference.
    """
    axes = tuple(range(dim))
    r = interpolate("r", axes, "r", "r_x")
    r_x = r.diff()
    r_xx = r_x.diff()
    power = 3 if strain == "green" else 2
    curvature = tuple(component / norm(r_x) ** power for component in cross(r_x, r_xx))
    square = None
    if dim == 3:  # Lagrange identity
        stretch = inner(r_x, r_x)
        square = (stretch * inner(r_xx, r_xx) - inner(r_x, r_xx) ** 2) / stretch**power
    if strain == "green":
        axial = Term(axial_stiffness, (r_x @ r_x - 1) / 2)
    else:
        axial = Term(axial_stiffness, norm(r_x) - 1, Gauss(5))
    where = {2: "planar", 3: "spatial"}[dim]
    rule = {"green": "in closed form", "biot": "at 5 Gauss points"}[strain]
    return Element(
        name=f"thin_{where}_{strain}{'_curved' * curved}",
        title=f"thin cable, {where}, {strain} strain; axial part {rule}, bending at 3 Gauss points"
        + "; curved where free of strain" * curved,
        dim=dim,
        node=(("r", axes), ("r_x", axes)),
        section=("r_x",),
        fields=(r_x, r_xx),
        energy=(axial, Term(bending_stiffness, curvature, Gauss(3), r_x, square)),
        inertia=((mass_per_length, r),),
        curved=curved,
    )
