"""L2T2: planar cable of Berzeri and Shabana (2000), axial model L2, bending model T2."""

from codegen.declarations.fields import Element, Term, interpolate, parameter

axial_stiffness = parameter("axial_stiffness")
bending_stiffness = parameter("bending_stiffness")
mass_per_length = parameter("mass_per_length")


def l2t2() -> Element:
    """U = 1/2 int EA eps^2 dx + 1/2 int EI r''.r'' dx with eps = (r'.r' - 1)/2."""
    plane = (0, 1)
    r = interpolate("r", plane, "r", "r_x")
    r_x = r.diff()
    r_xx = r_x.diff()
    return Element(
        name="l2t2",
        title="L2T2 cable, planar; axial and bending part in closed form",
        dim=2,
        node=(("r", plane), ("r_x", plane)),
        section=("r_x",),
        fields=(r_x, r_xx),
        energy=(
            Term(axial_stiffness, (r_x @ r_x - 1) / 2),
            Term(bending_stiffness, r_xx.components, turns_with=r_x),
        ),
        inertia=((mass_per_length, r),),
    )
