"""A beam in space with one section vector, r_y; the other is r_x x r_y."""

from codegen.declarations import Element, Gauss, Term, inner, interpolate, parameter

SPACE = (0, 1, 2)
r, r_y = interpolate("r", SPACE, "r", "r_x"), interpolate("r_y", SPACE, "r_y")
r_x, r_xx, r_yx = r.diff(), r.diff().diff(), r_y.diff()


def across(u):
    """Return (r_x x r_y) . u."""
    a, b, c = r_x.components, r_y.components, u.components
    return sum((a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2]) * c[i] for i in range(3))


ELEMENT = Element(
    name="ribbon",
    title="beam in space with one section vector",
    dim=3,
    node=(("r", SPACE), ("r_x", SPACE), ("r_y", SPACE)),
    section=("r_x", "r_y"),
    fields=(r_x, r_xx, r_y, r_yx),
    energy=(
        Term(parameter("axial_stiffness"), (r_x @ r_x - 1) / 2),
        Term(parameter("youngs_modulus_area"), (inner(r_y, r_y) - 1) / 2, Gauss(2)),
        Term(parameter("shear_stiffness_y"), inner(r_x, r_y), Gauss(2)),
        Term(parameter("torsion_stiffness"), across(r_yx), Gauss(2)),
        Term(parameter("bending_stiffness_y"), across(r_xx), Gauss(3)),
        Term(parameter("bending_stiffness_z"), inner(r_y, r_xx), Gauss(3)),
    ),
    inertia=((parameter("mass_per_length"), r), (parameter("inertia_y"), r_y)),
)
