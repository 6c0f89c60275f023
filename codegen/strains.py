"""Strains on the tape: their Legendre modes, or their values at a point.

Strains that share local variables form a patch.  The variables are the mode vectors, the components
of the fields at a Gauss point (constant combinations of mode vectors), or the mode vectors and the
coordinates of a node.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product

import sympy as sp

from codegen.declarations.fields import Element, Field, Gauss, Legendre, Term, length, x
from codegen.modes import ModeVectors, gauss_rule, legendre_value, product_modes
from codegen.symbols import Scaled, affine, combine, to_tape
from codegen.tape import Node, Tape

CARRIED_POINTS = 3
"""Gauss points for rates of vector strains with exact energy: directions are not polynomials."""


@dataclass
class Patch:
    """Pairs of weight and strain, and their variables in terms of mode vectors and coordinates.

    Column indices of the rows count the components of all mode vectors first, then the coordinates.
    `squares` are pairs of weight and square of a strain.
    """

    variables: list[Node]
    rows: list[list[tuple[Fraction, int]]]
    strains: list[tuple[Node, Node]] = field(default_factory=list)
    squares: list[tuple[Node, Node]] = field(default_factory=list)


class Sampler:
    """Converts strain expressions to nodes, each strain once."""

    def __init__(self, tape: Tape, element: Element) -> None:
        self.tape = tape
        self.named = dict(element.strains)
        self.fields = {f.name: f for f in element.fields}
        self.components = {
            symbol: (f, axis)
            for f in element.fields
            for symbol, axis in zip(f.components, f.axes, strict=True)
        }
        self._known: dict[sp.Expr, list[Scaled]] = {}

    def __call__(self, strain: sp.Expr) -> list[Scaled]:
        """Modes from the lowest, or the single value."""
        if strain not in self._known:
            self._known[strain] = self._evaluate(strain)
        return self._known[strain]

    def _evaluate(self, strain: sp.Expr) -> list[Scaled]:
        parts = affine(strain)
        if parts is None:
            return self._other(strain)
        constant, terms = parts
        sampled = [
            (factor, self(self.named[atom]) if atom in self.named else self._atom(atom))
            for atom, factor in terms
        ]
        result = []
        for k in range(max(len(values) for _, values in sampled)):
            members = [(f * v[k][0], v[k][1]) for f, v in sampled if k < len(v)]
            if k == 0:
                members.append((constant, self.tape.const(1)))
            result.append(combine(self.tape, members))
        return result

    def _atom(self, atom: sp.Expr) -> list[Scaled]:
        """Sample a component or a dot product."""
        raise NotImplementedError

    def _other(self, strain: sp.Expr) -> list[Scaled]:
        raise ValueError(f"the strain {strain} is not a polynomial; specify Gauss points")


class ModeSampler(Sampler):
    """Legendre modes of polynomial strains, exact."""

    def __init__(self, tape: Tape, element: Element, modes: ModeVectors) -> None:
        super().__init__(tape, element)
        self.modes = modes

    def _atom(self, atom: sp.Expr) -> list[Scaled]:
        if atom in self.components:
            f, axis = self.components[atom]
            return [(factor, self.modes.nodes[v][axis]) for factor, v in self.modes.of(f)]
        u, v = (self.modes.of(self.fields[str(name)]) for name in atom.args)
        result = []
        for k in range(len(u) + len(v) - 1):
            members = []
            for (m, (f_m, c_m)), (n, (f_n, c_n)) in product(enumerate(u), enumerate(v)):
                if coefficient := product_modes(m, n, k):
                    members.append((coefficient * f_m * f_n, self.modes.dot(c_m, c_n)))
            result.append(combine(self.tape, members))
        return result


class PointSampler(Sampler):
    """Values at a point, from the field components and projected strains there."""

    def __init__(self, tape: Tape, element: Element, values: dict[sp.Symbol, Scaled]) -> None:
        super().__init__(tape, element)
        self.values = values

    def _atom(self, atom: sp.Expr) -> list[Scaled]:
        if atom in self.values:
            return [self.values[atom]]
        u, v = (self.fields[str(name)] for name in atom.args)
        a, b = self._on(u, v.axes), self._on(v, u.axes)
        product_node = self.tape.dot([node for _, node in a], [node for _, node in b])
        return [(a[0][0] * b[0][0], product_node)]

    def carried(self, strains: Sequence[sp.Expr], f: Field) -> list[Scaled]:
        """Components of a vector strain c with its rate relative to a field u as derivatives.

        The direction of u rotates without twist, at the rate w = u x u' / |u|^2; the relative rate
        is c' - w x c, with w x c = ((u.c) u' - (c.u') u) / |u|^2.  Only the derivatives of the
        result are meaningful, not its values.
        """
        tape = self.tape
        (factor, *others), c = zip(*(self(s)[0] for s in strains), strict=True)
        if any(other != factor for other in others):
            raise ValueError(f"the components {strains} of a vector must have the same unit")
        u = [node for _, node in self._on(f, f.axes)]
        inverse = tape.pow(tape.dot(u, u), Fraction(-1))
        along = tape.freeze(tape.mul(tape.dot(u, c), inverse))
        back = tape.dot([tape.freeze(node) for node in c], u)
        result = []
        for c_k, u_k in zip(c, u, strict=True):
            turn = tape.mul(tape.freeze(tape.mul(u_k, inverse)), back)
            node = tape.linear([(1, c_k), (-1, tape.mul(along, u_k)), (1, turn)])
            result.append((factor, node))
        return result

    def square(self, expr: sp.Expr) -> Scaled:
        """Evaluate a rational function of components that is homogeneous in each field."""
        scaled = expr.subs({s: f * s for s, (f, _) in self.values.items()}, simultaneous=True)
        factor = sp.cancel(scaled / expr)
        if factor.has(*self.values):
            raise ValueError(f"the square {expr} is not homogeneous in its fields")
        return factor, to_tape(self.tape, expr, {s: node for s, (_, node) in self.values.items()})

    def _on(self, f: Field, axes: tuple[int, ...]) -> list[Scaled]:
        pairs = zip(f.components, f.axes, strict=True)
        return [self.values[symbol] for symbol, axis in pairs if axis in axes]

    def _other(self, strain: sp.Expr) -> list[Scaled]:
        """Any strain in components; a common factor of its variables is extracted if possible."""
        used = [s for s in self.values if strain.has(s)]
        nodes = {s: self.values[s][1] for s in used}
        factors = {self.values[s][0] for s in used} - {sp.Integer(1)}
        scaled = strain.subs({s: self.values[s][0] * s for s in used}, simultaneous=True)
        for factor in sorted(factors, key=str):
            if sp.expand(scaled - factor * strain) == 0:
                return [(factor, to_tape(self.tape, strain, nodes))]
        return [(sp.Integer(1), to_tape(self.tape, scaled, nodes))]


class Patches:
    """All strains of an element, with their weights, in patches.

    With `carried`, vector strains are evaluated at Gauss points with rates relative to the field
    they rotate with (`PointSampler.carried`).  With `squared`, those that have a square are
    represented by it.  `rest` holds the mode vectors of the shape in which there is no strain, if
    it is curved.
    """

    def __init__(
        self,
        tape: Tape,
        element: Element,
        modes: ModeVectors,
        *,
        carried: bool = False,
        squared: bool = False,
        rest: ModeVectors | None = None,
    ) -> None:
        self.tape = tape
        self.element = element
        self.modes = modes
        variables = modes.components()
        rows = [[(Fraction(1), i)] for i in range(len(variables))]
        self.exact = Patch(variables, rows)
        self._mode_sampler = ModeSampler(tape, element, modes)
        self._points: dict[Fraction, tuple[Patch, PointSampler]] = {}
        self._ends: dict[int, tuple[Patch, PointSampler]] = {}
        for term in element.energy:
            # A vector of one component is normal to the plane, so it does not rotate.
            if carried and len(term.strains) > 1:
                self._add_carried(term)
            elif squared and term.square is not None:
                self._add_square(term, term.square)
            else:
                for strain in term.strains:
                    self._add_strain(term, strain)
        self.all = [self.exact, *(p for p, _ in self._points.values())]
        self.all += [p for p, _ in self._ends.values()]
        if rest is not None:
            self._subtract(Patches(tape, element, rest))

    def _subtract(self, rest: "Patches") -> None:
        """Subtract from every strain its value in another shape."""
        for patch, other in zip(self.all, rest.all, strict=True):
            pairs = zip(patch.strains, other.strains, strict=True)
            patch.strains = [
                (weight, self.tape.linear([(1, strain), (-1, there)]))
                for (weight, strain), (_, there) in pairs
            ]

    def _add_strain(self, term: Term, strain: sp.Expr) -> None:
        if isinstance(term.rule, Legendre):
            self._add_modes(term, self._mode_sampler(strain)[: term.rule.modes])
        elif isinstance(term.rule, Gauss) and term.rule.modes is not None:
            self._add_modes(term, self._projected(strain, term.rule.points, term.rule.modes))
        elif isinstance(term.rule, Gauss):
            for xi, share in gauss_rule(term.rule.points):
                patch, sample = self._at_point(xi)
                self._add(patch, term.weight * length * sp.Rational(share), sample(strain)[0])
        else:
            for end in (0, 1):
                patch, sample = self._at_node(end)
                self._add(patch, term.weight * length / 2, sample(strain)[0])

    def _add_carried(self, term: Term) -> None:
        if term.turns_with is None:
            raise ValueError(f"the vector {term.strain} must rotate with a field (turns_with)")
        points = term.rule.points if isinstance(term.rule, Gauss) else CARRIED_POINTS
        for xi, share in gauss_rule(points):
            patch, sample = self._at_point(xi)
            for scaled in sample.carried(term.strains, term.turns_with):
                self._add(patch, term.weight * length * sp.Rational(share), scaled)

    def _add_square(self, term: Term, square: sp.Expr) -> None:
        if not isinstance(term.rule, Gauss):
            raise ValueError(f"the square {square} needs Gauss points")
        for xi, share in gauss_rule(term.rule.points):
            patch, sample = self._at_point(xi)
            factor, node = sample.square(square)
            weight = term.weight * length * sp.Rational(share) * factor
            patch.squares.append((to_tape(self.tape, weight, {}), node))

    def _add_modes(self, term: Term, modes: list[Scaled]) -> None:
        for k, mode in enumerate(modes):
            self._add(self.exact, term.weight * length / (2 * k + 1), mode)

    def _add(self, patch: Patch, weight: sp.Expr, strain: Scaled) -> None:
        """Append a strain, with its constant factor moved to the weight."""
        factor, node = strain
        coefficient, node = (1, node) if self.element.curved else self.tape.split(node)
        if self.tape.constant_value(node) is None:
            total = weight * factor**2 * sp.Rational(coefficient) ** 2
            patch.strains.append((to_tape(self.tape, total, {}), node))

    def _projected(self, strain: sp.Expr, points: int, n_modes: int) -> list[Scaled]:
        """First Legendre modes of a strain, by quadrature."""
        rule = gauss_rule(points)
        samples = [self._at_point(xi)[1](strain)[0] for xi, _ in rule]
        result = []
        for k in range(n_modes):
            members = [
                (factor * sp.Rational((2 * k + 1) * share * legendre_value(k, xi)), node)
                for (factor, node), (xi, share) in zip(samples, rule, strict=True)
            ]
            result.append(combine(self.tape, members))
        return result

    def _at_point(self, xi: Fraction) -> tuple[Patch, PointSampler]:
        """Local variables at a Gauss point: components of the fields, each without its factor."""
        if xi not in self._points:
            components, numbers = self.modes.components(), self.modes.numbers()
            patch = Patch([], [])
            values: dict[sp.Symbol, Scaled] = {}
            for f in self.element.fields:
                factor, ratios = self.modes.ratios(f)
                for symbol, axis in zip(f.components, f.axes, strict=True):
                    row = [
                        (ratio * legendre_value(m, xi), numbers[v, axis])
                        for m, (ratio, v) in enumerate(ratios)
                    ]
                    node = self.tape.linear([(value, components[i]) for value, i in row])
                    patch.variables.append(node)
                    patch.rows.append([(value, i) for value, i in row if value])
                    values[symbol] = (factor, node)
            self._points[xi] = patch, PointSampler(self.tape, self.element, values)
        return self._points[xi]

    def _at_node(self, end: int) -> tuple[Patch, PointSampler]:
        """Local variables at a node: its coordinates, which equal the fields there.

        Mode vectors precede them, for strains that are projected on linear functions.
        """
        if end not in self._ends:
            n = self.element.n_coordinates // 2
            places = range(end * n, (end + 1) * n)
            inputs, modes = self.modes.inputs, self.modes.components()
            numbers = [*range(len(modes)), *(len(modes) + i for i in places)]
            rows = [[(Fraction(1), i)] for i in numbers]
            patch = Patch([*modes, *(inputs[i] for i in places)], rows)
            values = {}
            for symbol, strain in self.element.projected:
                (f, mean), (g, half) = self._mode_sampler(strain)[:2]
                values[symbol] = combine(self.tape, [(f, mean), (g if end else -g, half)])
            for f in self.element.fields:
                shape = [s.subs(x, end * length) for s in f.shape]
                if sorted(shape, key=str) == [0] * (len(shape) - 1) + [1]:
                    for symbol, axis in zip(f.components, f.axes, strict=True):
                        place = self.element.places(f, axis)[shape.index(1)]
                        values[symbol] = (sp.Integer(1), inputs[place])
            self._ends[end] = patch, PointSampler(self.tape, self.element, values)
        return self._ends[end]
