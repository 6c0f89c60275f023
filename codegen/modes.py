"""Legendre modes of fields, their products, and Gauss points; exact or to forty digits."""

from collections.abc import Sequence
from fractions import Fraction
from functools import cache

import sympy as sp
from sympy.integrals.quadrature import gauss_legendre

from codegen.declarations.fields import Element, Field, length, x
from codegen.symbols import fraction, to_tape
from codegen.tape import Node, Tape

xi = sp.Symbol("xi")
DIGITS = 40


@cache
def product_modes(m: int, n: int, k: int) -> sp.Rational:
    """Coefficient of P_k in P_m P_n."""
    integrand = sp.legendre(m, xi) * sp.legendre(n, xi) * sp.legendre(k, xi)
    return sp.Rational(2 * k + 1, 2) * sp.integrate(sp.expand(integrand), (xi, -1, 1))


def legendre_value(m: int, at: Fraction) -> Fraction:
    """P_m at a point of [-1, 1]."""
    return fraction(sp.Poly(sp.legendre(m, xi), xi).eval(sp.Rational(at)))


@cache
def gauss_rule(n: int) -> list[tuple[Fraction, Fraction]]:
    """Points in [-1, 1], and weights as fractions of the length; exactly symmetric."""
    points, weights = gauss_legendre(n, DIGITS)
    upper = [
        (fraction(sp.Rational(str(p))), fraction(sp.Rational(str(w))) / 2)
        for p, w in zip(points, weights, strict=True)
    ]
    half = [(p, w) for p, w in upper if p > Fraction(1, 10**9)]
    middle = [(Fraction(0), w) for p, w in upper if abs(p) <= Fraction(1, 10**9)]
    return [*((-p, w) for p, w in reversed(half)), *middle, *half]


class ModeVectors:
    """The distinct Legendre mode vectors of an element's fields; fields are multiples of them.

    r_xx has no separate modes: they are multiples of those of r_x, and that of r_yx one of r_y.
    """

    def __init__(self, tape: Tape, element: Element, inputs: Sequence[Node]) -> None:
        self.tape = tape
        self.element = element
        self.inputs = inputs
        self.rows: list[tuple[Field, list[sp.Expr]]] = []
        self.nodes: list[dict[int, Node]] = []
        self._known: dict[str, list[tuple[sp.Expr, int]]] = {}
        self._dots: dict[tuple[int, int], Node] = {}

    def of(self, f: Field) -> list[tuple[sp.Expr, int]]:
        """Modes of a field from the lowest: a factor and the index of the mode vector."""
        if f.name not in self._known:
            degree = max(sp.Poly(s, x).degree() for s in f.shape)
            self._known[f.name] = [self._mode(f, m) for m in range(degree + 1)]
        return self._known[f.name]

    def _mode(self, f: Field, m: int) -> tuple[sp.Expr, int]:
        weight = sp.legendre(m, 2 * x / length - 1) * (2 * m + 1) / length
        row = [sp.expand(sp.integrate(sp.expand(s * weight), (x, 0, length))) for s in f.shape]
        for number, (other, known) in enumerate(self.rows):
            if (other.nodal, other.axes) == (f.nodal, f.axes):
                ratio = _ratio(row, known)
                if ratio is not None:
                    return ratio, number
        scale = _clear_denominators(row)
        row = [sp.expand(scale * entry) for entry in row]
        nodes = {}
        for axis in f.axes:
            places = self.element.places(f, axis)
            terms = [(c, self.inputs[p]) for c, p in zip(row, places, strict=True) if c != 0]
            nodes[axis] = self.form(terms)
        self.rows.append((f, row))
        self.nodes.append(nodes)
        return 1 / scale, len(self.rows) - 1

    def ratios(self, f: Field) -> tuple[sp.Expr, list[tuple[Fraction, int]]]:
        """One factor for the field and rational multiples of the mode vectors."""
        modes = self.of(f)
        common = next(factor for factor, _ in modes if factor != 0)
        return common, [(fraction(factor / common), v) for factor, v in modes]

    def form(self, terms: Sequence[tuple[sp.Expr, Node]]) -> Node:
        """Linear form whose coefficients are rational multiples of powers of the length."""
        groups: dict[sp.Expr, list[tuple[Fraction, Node]]] = {}
        for coefficient, node in terms:
            number, power = coefficient.as_coeff_Mul()
            groups.setdefault(power, []).append((fraction(number), node))
        return self.tape.linear(
            [
                (1, self.tape.mul(to_tape(self.tape, power, {}), self.tape.linear(members)))
                for power, members in groups.items()
            ]
        )

    def dot(self, u: int, v: int) -> Node:
        """Dot product of two mode vectors over their common directions."""
        key = (min(u, v), max(u, v))
        if key not in self._dots:
            a, b = self.nodes[key[0]], self.nodes[key[1]]
            common = [axis for axis in a if axis in b]
            self._dots[key] = self.tape.dot([a[i] for i in common], [b[i] for i in common])
        return self._dots[key]

    def components(self) -> list[Node]:
        """All components of all mode vectors in order."""
        return [node for vector in self.nodes for node in vector.values()]

    def numbers(self) -> dict[tuple[int, int], int]:
        """Index of component `axis` of vector `v` among all components."""
        keys = [(v, axis) for v, nodes in enumerate(self.nodes) for axis in nodes]
        return {key: i for i, key in enumerate(keys)}

    def matrix(self) -> list[dict[int, sp.Expr]]:
        """Differentiate all mode components by the coordinates: sparse rows."""
        return [
            {p: c for p, c in zip(self.element.places(f, axis), row, strict=True) if c != 0}
            for (f, row), nodes in zip(self.rows, self.nodes, strict=True)
            for axis in nodes
        ]


def _ratio(row: Sequence[sp.Expr], known: Sequence[sp.Expr]) -> sp.Expr | None:
    """Return the factor by which `known` equals `row`, if there is one."""
    if all(entry == 0 for entry in row):
        return sp.Integer(0)
    place = next(i for i, entry in enumerate(known) if entry != 0)
    factor = sp.simplify(row[place] / known[place])
    same = all(sp.expand(r - factor * k) == 0 for r, k in zip(row, known, strict=True))
    return factor if same and factor != 0 else None


def _clear_denominators(row: Sequence[sp.Expr]) -> sp.Rational:
    numbers = [entry.as_coeff_Mul()[0] for entry in row if entry != 0]
    multiple = sp.ilcm(*(n.q for n in numbers), 1)
    return sp.Rational(multiple, sp.igcd(*(n * multiple for n in numbers), 0))
