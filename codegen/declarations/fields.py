"""Terms for definitions of elements: vector fields along the axis, strains, rules, parameters."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import sympy as sp

from codegen.declarations.kernels import NAMES

x, length = sp.symbols("x length", positive=True)
dot = sp.Function("dot")

PARAMETERS = (
    "length",
    "axial_stiffness",
    "bending_stiffness",
    "lame_area",
    "shear_modulus_area",
    "youngs_modulus_area",
    "poisson_ratio",
    "shear_stiffness_y",
    "shear_stiffness_z",
    "torsion_stiffness",
    "bending_stiffness_y",
    "bending_stiffness_z",
    "mass_per_length",
    "inertia_y",
    "inertia_z",
)
"""All base parameters that elements may use, in the order in which modules list theirs."""


def parameter(name: str) -> sp.Symbol:
    """Return the symbol of a base parameter; the name must be one the scene can supply."""
    if name not in PARAMETERS:
        raise ValueError(
            f"{name!r} is not one of the base parameters {', '.join(PARAMETERS)}; define a "
            "parameter of a single element as an OwnParameter"
        )
    return sp.Symbol(name, positive=True)


GROUPS = ("stretching", "turning", "masses", "ratios")
"""Damping that applies to a parameter: axial, bending, mass-proportional (alpha), none."""


@dataclass(frozen=True)
class OwnParameter:
    """A parameter specific to one element, whose value is given with the element.

    Attributes
    ----------
    name : str
        Its name.
    group : str
        The damping that applies to it, one of `GROUPS`: a weight of strains belongs to
        ``"stretching"`` or ``"turning"``, a constant inside a strain, or a factor of another
        weight, to ``"ratios"``.
    """

    name: str
    group: str = "ratios"

    def __post_init__(self) -> None:
        """Reject names in use and unknown groups."""
        if not self.name.isidentifier() or self.name in (*PARAMETERS, "x"):
            raise ValueError(f"{self.name!r} cannot be the name of an own parameter")
        if self.group not in GROUPS:
            raise ValueError(f"the group of {self.name} is {self.group!r}, not one of {GROUPS}")

    @property
    def symbol(self) -> sp.Symbol:
        """Its symbol in energies."""
        return sp.Symbol(self.name, positive=True)


@dataclass(frozen=True)
class Field:
    """A vector field interpolated between two nodes.

    `nodal` lists the nodal vectors at the start, then at the end; `shape` has one polynomial in x
    for each of them.  `axes` are those of the three directions in which the vector has components.
    """

    name: str
    axes: tuple[int, ...]
    nodal: tuple[str, ...]
    shape: tuple[sp.Expr, ...]

    def diff(self) -> "Field":
        """Differentiate along the axis: r -> r_x -> r_xx, r_y -> r_yx."""
        name = self.name + ("x" if "_" in self.name else "_x")
        return Field(name, self.axes, self.nodal, tuple(sp.diff(s, x) for s in self.shape))

    @property
    def components(self) -> tuple[sp.Symbol, ...]:
        """One symbol per direction, r_x1, r_x2, ..."""
        return tuple(sp.Symbol(f"{self.name}{axis + 1}", real=True) for axis in self.axes)

    def __matmul__(self, other: "Field") -> sp.Expr:
        """Dot product, kept as one symbol; zero for fields without a common direction."""
        if not set(self.axes) & set(other.axes):
            return sp.Integer(0)
        return dot(*sorted((sp.Symbol(self.name), sp.Symbol(other.name)), key=str))


def interpolate(name: str, axes: Sequence[int], *nodal: str) -> Field:
    """Polynomial field with nodal vectors at both ends: the value and, if named, the slope.

    Each shape function is one for its own nodal vector and zero for the others.
    """
    n = 2 * len(nodal)
    powers = [x**k for k in range(n)]
    conditions = sp.Matrix(
        [
            [sp.diff(p, x, order).subs(x, end) for p in powers]
            for end in (sp.Integer(0), length)
            for order in range(len(nodal))
        ]
    )
    shape = sp.Matrix([powers]) * conditions.inv()
    return Field(name, tuple(axes), nodal * 2, tuple(sp.expand(s) for s in shape))


def cross(u: Field, v: Field) -> list[sp.Expr]:
    """Components of u x v: one in the plane, three in space."""
    a, b = u.components, v.components
    pairs = [(0, 1)] if len(a) == 2 else [(1, 2), (2, 0), (0, 1)]
    return [a[i] * b[j] - a[j] * b[i] for i, j in pairs]


def inner(u: Field, v: Field) -> sp.Expr:
    """Dot product of fields with the same directions, written in components."""
    return sum(a * b for a, b in zip(u.components, v.components, strict=True))


def norm(u: Field) -> sp.Expr:
    """Length of a vector, from its components."""
    return sp.sqrt(inner(u, u))


@dataclass(frozen=True)
class Legendre:
    """Exact integral of the square of a polynomial strain, or of its first Legendre modes."""

    modes: int | None = None


@dataclass(frozen=True)
class Gauss:
    """Gauss points; with `modes`, the square of the projection on that many polynomials."""

    points: int
    modes: int | None = None


@dataclass(frozen=True)
class Nodal:
    """Trapezoidal rule: the strain at the two nodes, including those of `Element.projected`."""


Rule = Legendre | Gauss | Nodal


@dataclass(frozen=True)
class Term:
    """Energy 1/2 int weight strain^2 dx, integrated by a rule.

    A strain may be a spatial vector that rotates with a field: the strain rate of the material is
    its rate relative to that rotation.  `square` is the square of a vector that is not a quadratic
    function of the coordinates, in terms of dot products, each in components.
    """

    weight: sp.Expr
    strain: sp.Expr | tuple[sp.Expr, ...]
    rule: Rule = field(default_factory=Legendre)
    turns_with: Field | None = None
    square: sp.Expr | None = None

    @property
    def strains(self) -> tuple[sp.Expr, ...]:
        """The strain, or its components."""
        return self.strain if isinstance(self.strain, tuple) else (self.strain,)


@dataclass(frozen=True)
class Element:
    """The definition of an element, from which everything else is derived.

    `node` lists the nodal vectors in the order of the coordinates; `section` those of them that
    rotate with the section, which a clamp fixes and a moment acts on.  `strains` defines symbols
    that terms may use, `projected` symbols for the projections of strains on linear functions of x;
    `inertia` pairs a mass per length with the field whose square it multiplies.  A `curved` element
    has a stress-free reference shape, whose coordinates are parameters and whose strains are
    subtracted.
    """

    name: str
    title: str
    dim: int
    node: tuple[tuple[str, tuple[int, ...]], ...]
    section: tuple[str, ...]
    fields: tuple[Field, ...]
    energy: tuple[Term, ...]
    inertia: tuple[tuple[sp.Expr, Field], ...]
    strains: tuple[tuple[sp.Symbol, sp.Expr], ...] = ()
    projected: tuple[tuple[sp.Symbol, sp.Expr], ...] = ()
    kernels: tuple[str, ...] = NAMES
    own: tuple[OwnParameter, ...] = ()
    curved: bool = False

    def __post_init__(self) -> None:
        """Reject definitions that the package cannot number, clamp or load.

        Raises
        ------
        ValueError
            With the requirement that is violated.
        """
        if not self.name.isidentifier():
            raise ValueError(f"the name of an element must be an identifier, not {self.name!r}")
        if self.dim not in (2, 3):
            raise ValueError(f"{self.name} has dim = {self.dim}; it must be 2 or 3")
        space = tuple(range(self.dim))
        if not self.energy or not self.inertia:
            raise ValueError(f"{self.name} must have an energy and an inertia")
        if self.node == (("r", space),) and not self.section:
            return  # straight between its nodes
        if self.node[:2] != (("r", space), ("r_x", space)):
            raise ValueError(
                f"the nodes of {self.name} must begin with ('r', {space}) and ('r_x', {space}), "
                f"positions and slopes of the cubic along its axis, or consist of ('r', {space}) "
                "alone"
            )
        vectors = [name for name, _ in self.node]
        strange = [
            name
            for name, axes in self.node[2:]
            if name not in ("r_y", "r_z") or (axes != space and (self.dim, axes) != (2, (2,)))
        ]
        if strange or len(set(vectors)) < len(vectors):
            raise ValueError(
                f"{self.name} has the nodal vectors {', '.join(vectors)}; besides r and r_x only "
                "r_y and r_z are possible, in the directions of the scene, or for r_z in the plane "
                "only in direction 2"
            )
        if not self.section or not set(self.section) <= set(vectors[1:]):
            raise ValueError(
                f"the section of {self.name} must name some of its nodal vectors "
                f"{', '.join(vectors[1:])}, not {self.section}"
            )
        if self.dim == 3 and self.section != ("r_x",) and len(set(self.section)) < 2:
            raise ValueError(
                f"the section of {self.name} must name at least two vectors, or only the slope, "
                f"not {self.section}: one vector does not define its rotation"
            )
        if not set(self.section) & {"r_x"} and not {"r_y", "r_z"} <= set(vectors):
            raise ValueError(
                f"the section of {self.name} rotates independently of r_x, so it needs r_y and r_z"
            )

    @property
    def node_coordinates(self) -> tuple[str, ...]:
        """Labels of the coordinates of one node: r_1, r_2, r_x1, ..."""
        return tuple(
            f"{name}{'' if '_' in name else '_'}{axis + 1}"
            for name, axes in self.node
            for axis in axes
        )

    @property
    def n_coordinates(self) -> int:
        """Coordinates of both nodes."""
        return 2 * len(self.node_coordinates)

    @property
    def reference(self) -> tuple[str, ...]:
        """Names of the parameters that are coordinates of both nodes in the reference shape."""
        return tuple(f"reference_{k}" for k in range(self.n_coordinates)) if self.curved else ()

    def place(self, end: int, nodal: str, axis: int) -> int:
        """Return the index of a coordinate within the element."""
        offset = end * len(self.node_coordinates)
        for name, axes in self.node:
            if name == nodal:
                return offset + axes.index(axis)
            offset += len(axes)
        raise ValueError(f"{self.name} has no nodal vector {nodal!r}")

    def places(self, f: Field, axis: int) -> list[int]:
        """Coordinates that multiply the shape functions of one component of a field."""
        half = len(f.nodal) // 2
        return [self.place(i // half, nodal, axis) for i, nodal in enumerate(f.nodal)]
