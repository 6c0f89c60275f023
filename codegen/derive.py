"""From an element to the programs of its kernels.

Fields become Legendre modes (linear in the coordinates), strains become nodes on a tape, the energy is a
sum of weighted squares of them.  The force is its reverse pass.  The tangent is, in the variables the
strains are written in, weight times the outer product of strain gradients plus the second derivative
of the strains with their stresses frozen; constant matrices carry it to the coordinates.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product

import sympy as sp

from codegen.fields import Element, Legendre, Nodal, Term, length
from codegen.modes import ModeVectors, gauss_rule, legendre_value, product_modes
from codegen.symbols import Scaled, affine, combine, to_tape
from codegen.tape import PARAMETER, Node, Tape

Triangle = dict[tuple[int, int], Node]


@dataclass
class Patch:
    """Strains that share local variables, which are linear in mode vectors or are coordinates."""

    variables: list[Node]
    rows: list[list[tuple[Fraction, int]]]
    in_coordinates: bool
    strains: list[tuple[Node, Node]] = field(default_factory=list)


@dataclass(frozen=True)
class Program:
    """Everything the emitter prints: outputs of every kernel on one tape."""

    element: Element
    tape: Tape
    outputs: dict[str, list[Node]]
    parameters: list[str]
    derived: list[Node]

    def operations(self) -> dict[str, int]:
        """Arithmetic operations per element, gather and scatter not counted."""
        return {name: self.tape.operations(nodes) for name, nodes in self.outputs.items()}


class Derivation:
    """Holds the tape while one element is worked out."""

    def __init__(self, element: Element) -> None:
        self.element = element
        self.tape = Tape()
        n = element.n_coordinates
        self.q = [self.tape.coordinate(i) for i in range(n)]
        self.a = [self.tape.acceleration(i) for i in range(n)]
        self.fields = {f.name: f for f in element.fields}
        self.component = {
            symbol: (f, axis)
            for f in element.fields
            for symbol, axis in zip(f.components, f.axes, strict=True)
        }
        self.strains = dict(element.strains)
        self.modes = ModeVectors(self.tape, element, self.q)
        for f in element.fields:
            self.modes.of(f)
        self.patches = self._patches()

    # Strains

    def _patches(self) -> list[Patch]:
        patches: dict[object, Patch] = {}
        known: dict[object, list[Scaled]] = {}
        c = [node for vector in self.modes.nodes for node in vector.values()]
        exact = Patch(c, [[(Fraction(1), i)] for i in range(len(c))], in_coordinates=False)
        for term in self.element.energy:
            if isinstance(term.rule, Legendre):
                patches.setdefault("exact", exact)
                self._legendre(term, exact, known)
            elif isinstance(term.rule, Nodal):
                for end in (0, 1):
                    patch = patches.setdefault((term.rule, end), self._at_node(end))
                    weight = term.weight * length / 2
                    self._point(term, patch, weight, known, (term.rule, end))
            elif term.rule.modes is None:
                for i, (xi, share) in enumerate(gauss_rule(term.rule.points)):
                    patch = patches.setdefault((term.rule, i), self._at_point(xi))
                    weight = term.weight * length * sp.Rational(share)
                    self._point(term, patch, weight, known, (term.rule, i))
            else:
                patches.setdefault("exact", exact)
                self._projected(term, exact, known)
        return list(patches.values())

    def _add(self, patch: Patch, weight: sp.Expr, strain: Scaled) -> None:
        """Append a strain, its constant factor moved into the weight."""
        factor, node = strain
        coefficient, node = self.tape.split(node)
        if self.tape.constant_value(node) is None:
            total = weight * factor**2 * sp.Rational(coefficient) ** 2
            patch.strains.append((to_tape(self.tape, total, {}), node))

    def _legendre(self, term: Term, patch: Patch, known: dict[object, list[Scaled]]) -> None:
        modes = self._modes(term.strain, known)
        for k, mode in enumerate(modes[: term.rule.modes]):  # type: ignore[union-attr]
            self._add(patch, term.weight * length / (2 * k + 1), mode)

    def _modes(self, strain: sp.Expr, known: dict[object, list[Scaled]]) -> list[Scaled]:
        """Legendre modes of a strain that is affine in dot products, components and named strains."""
        if strain not in known:
            constant, terms = affine(strain)
            parts = [(coefficient, self._atom_modes(atom, known)) for atom, coefficient in terms]
            modes = []
            for k in range(max(len(p) for _, p in parts)):
                members = [(c * p[k][0], p[k][1]) for c, p in parts if k < len(p)]
                if k == 0:
                    members.append((constant, self.tape.const(1)))
                modes.append(combine(self.tape, members))
            known[strain] = modes
        return known[strain]

    def _atom_modes(self, atom: sp.Expr, known: dict[object, list[Scaled]]) -> list[Scaled]:
        if atom in self.strains:
            return self._modes(self.strains[atom], known)
        if atom in self.component:
            f, axis = self.component[atom]
            return [(factor, self.modes.nodes[v][axis]) for factor, v in self.modes.of(f)]
        u, v = (self.modes.of(self.fields[str(name)]) for name in atom.args)
        result = []
        for k in range(len(u) + len(v) - 1):
            members = []
            for (m, (f_m, c_m)), (n, (f_n, c_n)) in product(enumerate(u), enumerate(v)):
                coefficient = product_modes(m, n, k)
                if coefficient:
                    members.append((coefficient * f_m * f_n, self.modes.dot(c_m, c_n)))
            result.append(combine(self.tape, members))
        return result

    def _at_node(self, end: int) -> Patch:
        """Local variables at a node: the coordinates of that node."""
        n = len(self.q) // 2
        places = list(range(end * n, end * n + n))
        rows = [[(Fraction(1), i)] for i in places]
        return Patch([self.q[i] for i in places], rows, in_coordinates=True)

    def _at_point(self, xi: Fraction) -> Patch:
        """Local variables at a point: the components of all fields, each without its factor."""
        variables, rows = [], []
        numbers = self.modes.numbers()
        for f in self.element.fields:
            _, ratios = self.modes.ratios(f)
            for axis in f.axes:
                row = [
                    (ratio * legendre_value(m, xi), numbers[v, axis])
                    for m, (ratio, v) in enumerate(ratios)
                ]
                row = [(value, i) for value, i in row if value]
                flat = [node for vector in self.modes.nodes for node in vector.values()]
                variables.append(self.tape.linear([(value, flat[i]) for value, i in row]))
                rows.append(row)
        return Patch(variables, rows, in_coordinates=False)

    def _values(self, patch: Patch, end: int | None) -> dict[sp.Expr, Scaled]:
        """Factor and node of every field component in a patch."""
        values: dict[sp.Expr, Scaled] = {}
        if end is None:
            symbols = [(s, f) for f in self.element.fields for s in f.components]
            for (symbol, f), node in zip(symbols, patch.variables, strict=True):
                values[symbol] = (self.modes.ratios(f)[0], node)
            return values
        for symbol, (f, axis) in self.component.items():
            shape = [s.subs(sp.Symbol("x", positive=True), end * length) for s in f.shape]
            places = self.element.places(f, axis)
            if all(s in (0, 1) for s in shape):
                terms = [(Fraction(int(s)), self.q[p]) for s, p in zip(shape, places, strict=True)]
                values[symbol] = (sp.Integer(1), self.tape.linear(terms))
        return values

    def _point(
        self,
        term: Term,
        patch: Patch,
        weight: sp.Expr,
        known: dict[object, list[Scaled]],
        where: tuple[object, int],
    ) -> None:
        end = where[1] if patch.in_coordinates else None
        values = self._values(patch, end)
        self._add(patch, weight, self._value(term.strain, values, known, where))

    def _value(
        self,
        strain: sp.Expr,
        values: dict[sp.Expr, Scaled],
        known: dict[object, list[Scaled]],
        where: tuple[object, int],
    ) -> Scaled:
        """Value of a strain at a point."""
        key = (strain, where)
        if key in known:
            return known[key][0]
        try:
            constant, terms = affine(strain)
        except ValueError:
            value = self._rational(strain, values)
        else:
            members = [(constant, self.tape.const(1))]
            for atom, coefficient in terms:
                if atom in self.strains:
                    factor, node = self._value(self.strains[atom], values, known, where)
                elif atom in values:
                    factor, node = values[atom]
                else:
                    factor, node = self._dot(atom, values)
                members.append((coefficient * factor, node))
            value = combine(self.tape, members)
        known[key] = [value]
        return value

    def _dot(self, atom: sp.Expr, values: dict[sp.Expr, Scaled]) -> Scaled:
        u, v = (self.fields[str(name)] for name in atom.args)
        common = [axis for axis in u.axes if axis in v.axes]
        a = [values[u.components[u.axes.index(axis)]] for axis in common]
        b = [values[v.components[v.axes.index(axis)]] for axis in common]
        return a[0][0] * b[0][0], self.tape.dot([n for _, n in a], [n for _, n in b])

    def _rational(self, strain: sp.Expr, values: dict[sp.Expr, Scaled]) -> Scaled:
        """Any other strain; a common factor of its variables is taken out where it can be."""
        used = [s for s in values if strain.has(s)]
        factors = {values[s][0] for s in used} - {sp.Integer(1)}
        scaled = strain.subs({s: values[s][0] * s for s in used}, simultaneous=True)
        for factor in sorted(factors, key=str):
            if sp.expand(scaled - factor * strain) == 0:
                return factor, to_tape(self.tape, strain, {s: values[s][1] for s in used})
        return sp.Integer(1), to_tape(self.tape, scaled, {s: values[s][1] for s in used})

    def _projected(self, term: Term, patch: Patch, known: dict[object, list[Scaled]]) -> None:
        """First Legendre modes of a strain, found by quadrature."""
        rule = term.rule
        assert not isinstance(rule, Legendre | Nodal) and rule.modes is not None
        points = list(enumerate(gauss_rule(rule.points)))
        values = [self._values(self._at_point(xi), None) for _, (xi, _) in points]
        samples = [
            self._value(term.strain, values[i], known, ("at", xi)) for i, (xi, _) in points
        ]
        for k in range(rule.modes):
            members = [
                (factor * sp.Rational((2 * k + 1) * share * legendre_value(k, xi)), node)
                for (factor, node), (_, (xi, share)) in zip(samples, points, strict=True)
            ]
            self._add(patch, term.weight * length / (2 * k + 1), combine(self.tape, members))

    # Kernels

    def energy(self) -> Node:
        stresses = [
            (s, self.tape.mul(weight, s)) for patch in self.patches for weight, s in patch.strains
        ]
        return self.tape.scale(
            Fraction(1, 2), self.tape.linear([(1, self.tape.mul(s, g)) for s, g in stresses])
        )

    def force(self) -> list[Node]:
        return self.tape.gradient(self.energy(), self.q)

    def inertia(self) -> list[Node]:
        """M a, from the Legendre modes of the accelerations."""
        modes = ModeVectors(self.tape, self.element, self.a)
        terms = []
        for weight, f in self.element.inertia:
            for k, (factor, vector) in enumerate(modes.of(f)):
                w = to_tape(self.tape, weight * length * factor**2 / (2 * k + 1), {})
                terms += [
                    (Fraction(1, 2), self.tape.mul(c, self.tape.mul(w, c)))
                    for c in modes.nodes[vector].values()
                ]
        return self.tape.gradient(self.tape.linear(terms), self.a)

    def mass(self) -> list[Node]:
        """Lower triangle of M by rows, exact."""
        x = sp.Symbol("x", positive=True)
        n = len(self.q)
        entries = {(i, j): sp.Integer(0) for i in range(n) for j in range(i + 1)}
        for weight, f in self.element.inertia:
            for axis in f.axes:
                places = self.element.places(f, axis)
                for (i, s), (j, t) in product(zip(places, f.shape, strict=True), repeat=2):
                    if j <= i:
                        entries[i, j] += weight * sp.integrate(sp.expand(s * t), (x, 0, length))
        return [to_tape(self.tape, entry, {}) for entry in entries.values()]

    def tangent(self) -> list[Node]:
        """Lower triangle of dQ/dq by rows."""
        n_modes = sum(len(vector) for vector in self.modes.nodes)
        by_modes: dict[tuple[int, int], list[tuple[Fraction, Node]]] = {}
        by_coordinates: dict[tuple[int, int], list[tuple[Fraction, Node]]] = {}
        for patch in self.patches:
            hessian = self._hessian(patch)
            target = by_coordinates if patch.in_coordinates else by_modes
            for (i, j), terms in project(self.tape, hessian, patch.rows).items():
                target.setdefault((i, j), []).extend(terms)
        inner = {key: self.tape.linear(terms) for key, terms in by_modes.items()}
        matrix = self.modes.matrix()
        n = len(self.q)
        half = [
            [self._form(inner, matrix, i, column) for column in range(n)] for i in range(n_modes)
        ]
        result = []
        for i in range(n):
            for j in range(i + 1):
                terms = [(matrix[m][i], half[m][j]) for m in range(n_modes) if i in matrix[m]]
                node = self.modes.form(terms)
                extra = by_coordinates.get((i, j), [])
                result.append(self.tape.linear([(Fraction(1), node), *extra]))
        return result

    def _form(
        self, inner: Triangle, matrix: Sequence[dict[int, sp.Expr]], row: int, column: int
    ) -> Node:
        terms = []
        for m, entries in enumerate(matrix):
            node = inner.get((max(row, m), min(row, m)))
            if node is not None and column in entries:
                terms.append((entries[column], node))
        return self.modes.form(terms)

    def _hessian(self, patch: Patch) -> Triangle:
        """Second derivative of the energy of a patch in its own variables, lower triangle."""
        tape = self.tape
        entries: dict[tuple[int, int], list[tuple[Fraction, Node]]] = {}
        potential = []
        for weight, strain in patch.strains:
            slope = tape.gradient(strain, patch.variables)
            potential.append((1, tape.mul(tape.freeze(tape.mul(weight, strain)), strain)))
            for i, left in enumerate(slope):
                stiff = tape.mul(weight, left)
                for j, right in enumerate(slope[: i + 1]):
                    entries.setdefault((i, j), []).append((Fraction(1), tape.mul(stiff, right)))
        gradient = tape.gradient(tape.linear(potential), patch.variables)
        for i, component in enumerate(gradient):
            second = tape.gradient(component, patch.variables[: i + 1])
            for j, node in enumerate(second):
                entries.setdefault((i, j), []).append((Fraction(1), node))
        sums = {key: tape.linear(terms) for key, terms in entries.items()}
        return {key: node for key, node in sums.items() if tape.constant_value(node) != 0}


def project(
    tape: Tape, hessian: Triangle, rows: Sequence[Sequence[tuple[Fraction, int]]]
) -> dict[tuple[int, int], list[tuple[Fraction, Node]]]:
    """Carry a symmetric matrix through constant rows: terms of the lower triangle of B^T H B."""
    columns = sorted({i for row in rows for _, i in row})
    half: dict[tuple[int, int], Node] = {}
    for local in range(len(rows)):
        for column in columns:
            terms = []
            for other, row in enumerate(rows):
                node = hessian.get((max(local, other), min(local, other)))
                if node is not None:
                    terms += [(value, node) for value, i in row if i == column]
            if terms:
                half[local, column] = tape.linear(terms)
    result: dict[tuple[int, int], list[tuple[Fraction, Node]]] = {}
    for local, row in enumerate(rows):
        for value, i in row:
            for j in columns:
                if j <= i and (local, j) in half:
                    result.setdefault((i, j), []).append((value, half[local, j]))
    return result


def derive(element: Element) -> Program:
    """Work out all kernels of an element."""
    d = Derivation(element)
    force, inertia = d.force(), d.inertia()
    makers = {
        "energy": lambda: [d.energy()],
        "force": lambda: force,
        "inertia": lambda: inertia,
        "residual": lambda: [
            d.tape.linear([(1, f), (1, m)]) for f, m in zip(force, inertia, strict=True)
        ],
        "tangent": d.tangent,
        "mass": d.mass,
    }
    outputs = {name: d.tape.lowered(makers[name]()) for name in element.kernels}
    tape = d.tape
    derived: set[Node] = set()
    for nodes in outputs.values():
        derived.update(n for n in nodes if tape.level[n] == PARAMETER)
        for node in tape.reachable(nodes):
            if tape.level[node] > PARAMETER:
                derived.update(a for a in tape[node].args if tape.level[a] == PARAMETER)
    used = {str(tape[n].value) for n in tape.reachable(derived) if tape[n].op == "parameter"}
    from codegen.fields import PARAMETERS

    names = [name for name in PARAMETERS if name in used]
    return Program(element, tape, outputs, names, sorted(derived))
