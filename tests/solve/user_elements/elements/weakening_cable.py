"""A planar cable whose bending weakens: moment EI k / (1 + (k / limit)^2)^2 at the curvature k."""

import sympy as sp

from codegen.declarations import (
    Element,
    Gauss,
    OwnParameter,
    Term,
    cross,
    interpolate,
    norm,
    parameter,
)

PLANE = (0, 1)
r = interpolate("r", PLANE, "r", "r_x")
r_x, r_xx = r.diff(), r.diff().diff()
limit = OwnParameter("curvature_limit")
curvature = cross(r_x, r_xx)[0] / norm(r_x) ** 3
ELEMENT = Element(
    name="weakening_cable",
    title="planar cable whose bending weakens",
    dim=2,
    node=(("r", PLANE), ("r_x", PLANE)),
    section=("r_x",),
    fields=(r_x, r_xx),
    energy=(
        Term(parameter("axial_stiffness"), (r_x @ r_x - 1) / 2),
        Term(
            parameter("bending_stiffness"),
            curvature / sp.sqrt(1 + curvature**2 / limit.symbol**2),
            Gauss(3),
        ),
    ),
    inertia=((parameter("mass_per_length"), r),),
    own=(limit,),
)
