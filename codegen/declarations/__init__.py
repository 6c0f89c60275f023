"""Terms that elements are declared with, and the kernels derived for them."""

from codegen.declarations.fields import (
    PARAMETERS as PARAMETERS,
    Element as Element,
    Field as Field,
    Gauss as Gauss,
    Legendre as Legendre,
    Nodal as Nodal,
    OwnParameter as OwnParameter,
    Term as Term,
    cross as cross,
    inner as inner,
    interpolate as interpolate,
    length as length,
    norm as norm,
    parameter as parameter,
    x as x,
)
