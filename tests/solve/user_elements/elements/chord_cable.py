"""A cable of a user's own: it bends by r'', not by the curvature."""

from codegen.declarations import Element, Term, interpolate, parameter

SPACE = (0, 1, 2)
r = interpolate("r", SPACE, "r", "r_x")
r_x, r_xx = r.diff(), r.diff().diff()
ELEMENT = Element(
    name="chord_cable",
    title="cable in space that bends by r''",
    dim=3,
    node=(("r", SPACE), ("r_x", SPACE)),
    section=("r_x",),
    fields=(r_x, r_xx),
    energy=(
        Term(parameter("axial_stiffness"), (r_x @ r_x - 1) / 2),
        Term(parameter("bending_stiffness"), r_xx.components, turns_with=r_x),
    ),
    inertia=((parameter("mass_per_length"), r),),
)
