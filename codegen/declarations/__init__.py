"""Terms that elements are declared with, and the kernels derived for them."""

from codegen.declarations.fields import (
    PARAMETERS,
    Element,
    Field,
    Gauss,
    Legendre,
    Nodal,
    OwnParameter,
    Term,
    cross,
    inner,
    interpolate,
    length,
    norm,
    parameter,
    x,
)

__all__ = [
    "PARAMETERS",
    "Element",
    "Field",
    "Gauss",
    "Legendre",
    "Nodal",
    "OwnParameter",
    "Term",
    "cross",
    "inner",
    "interpolate",
    "length",
    "norm",
    "parameter",
    "x",
]
