"""From an element to the programs of its kernels.

The energy is a sum of weighted squares of strains (`strains`), and the force is its gradient by
reverse-mode differentiation.  In the local variables of the strains, the tangent is weight times
the outer product of strain gradients plus the second derivative of the strains at constant stress;
constant matrices then transform it to the coordinates.  The outer products alone are the material
part of the tangent; applied to velocities they give the viscous damping force.  Between two states
the force is the discrete gradient of the energy (`discrete_gradient`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import product

import sympy as sp

from codegen.declarations.fields import PARAMETERS, Element, length, x
from codegen.discrete_gradient import HALF, DiscreteGradient
from codegen.modes import ModeVectors
from codegen.strains import Patch, Patches
from codegen.symbols import to_tape
from codegen.tape import PARAMETER, Node, Tape

Triangle = dict[tuple[int, int], Node]
Terms = dict[tuple[int, int], list[tuple[Fraction, Node]]]


@dataclass(frozen=True)
class Program:
    """All that the emitter prints.

    `outputs` are the nodes of every kernel on one tape, `parameters` the base parameters by name,
    and `derived` the nodes that `prepare` computes for all kernels.
    """

    element: Element
    tape: Tape
    outputs: dict[str, list[Node]]
    parameters: list[str]
    derived: list[Node]

    def operations(self) -> dict[str, int]:
        """Arithmetic operations per element; gather and scatter are not counted."""
        return {name: self.tape.operations(nodes) for name, nodes in self.outputs.items()}


class Derivation:
    """Derivation of the kernels of one element on one tape."""

    def __init__(self, element: Element) -> None:
        self.element = element
        self.tape = Tape()
        n = element.n_coordinates
        self.q = [self.tape.coordinate(i) for i in range(n)]
        self.a = [self.tape.acceleration(i) for i in range(n)]
        self.modes = ModeVectors(self.tape, element, self.q)
        self.rest = None
        if element.curved:
            there = [self.tape.parameter(name) for name in element.reference]
            self.rest = ModeVectors(self.tape, element, there)
        for f in element.fields:
            self.modes.of(f)
            if self.rest is not None:
                self.rest.of(f)
        self.patches = Patches(self.tape, element, self.modes, rest=self.rest).all

    def energy(self) -> list[Node]:
        """Half the sum of strain times stress."""
        tape = self.tape
        pairs = [pair for patch in self.patches for pair in patch.strains]
        squares = [(Fraction(1), tape.mul(s, tape.mul(weight, s))) for weight, s in pairs]
        return [tape.scale(Fraction(1, 2), tape.linear(squares))]

    def force(self) -> list[Node]:
        """Gradient of the energy with respect to the coordinates."""
        return self.tape.gradient(self.energy()[0], self.q)

    def inertia(self) -> list[Node]:
        """M a: gradient of half the weighted squares of the modes of the accelerations."""
        tape = self.tape
        modes = ModeVectors(tape, self.element, self.a)
        terms = []
        for density, f in self.element.inertia:
            for k, (factor, vector) in enumerate(modes.of(f)):
                weight = to_tape(tape, density * length * factor**2 / (2 * k + 1), {})
                for c in modes.nodes[vector].values():
                    terms.append((Fraction(1, 2), tape.mul(c, tape.mul(weight, c))))
        return tape.gradient(tape.linear(terms), self.a)

    def residual(self) -> list[Node]:
        """Q(q) + M a."""
        pairs = zip(self.force(), self.inertia(), strict=True)
        return [self.tape.add(force, inertia) for force, inertia in pairs]

    def mass(self) -> list[Node]:
        """Lower triangle of M by rows, exact."""
        n = len(self.q)
        entries = {(i, j): sp.Integer(0) for i in range(n) for j in range(i + 1)}
        for density, f in self.element.inertia:
            for axis in f.axes:
                row = list(zip(self.element.places(f, axis), f.shape, strict=True))
                for (i, s), (j, t) in product(row, repeat=2):
                    if j <= i:
                        entries[i, j] += density * sp.integrate(sp.expand(s * t), (x, 0, length))
        return [to_tape(self.tape, entry, {}) for entry in entries.values()]

    @cached_property
    def carried(self) -> list[Patch]:
        """Patches of strains whose derivatives vanish in rigid rotations of the element."""
        return Patches(self.tape, self.element, self.modes, carried=True).all

    def damping(self) -> list[Node]:
        """Sum of weight * strain rate * strain gradient; a has the velocities."""
        tape = self.tape
        pairs = [pair for patch in self.carried for pair in patch.strains]
        rates = tape.directional([s for _, s in pairs], dict(zip(self.q, self.a, strict=True)))
        terms = [
            (Fraction(1), tape.mul(tape.freeze(tape.mul(weight, rate)), strain))
            for (weight, strain), rate in zip(pairs, rates, strict=True)
        ]
        return tape.gradient(tape.linear(terms), self.q)

    def discrete_gradient(self) -> list[Node]:
        """Sum of weight * mean strain * difference quotient of the strain between q and a.

        Here a is the second state.  Vectors whose components are not quadratic
        functions enter by their square: their components alone would exert a moment on the beam.
        """
        tape = self.tape
        discrete = DiscreteGradient(tape, dict(zip(self.q, self.a, strict=True)))
        outputs = []
        patches = Patches(tape, self.element, self.modes, squared=True, rest=self.rest).all
        for patch in patches:
            outputs += [(tape.mul(weight, discrete.mean(s)), s) for weight, s in patch.strains]
            outputs += [(tape.scale(HALF, weight), square) for weight, square in patch.squares]
        return discrete.gradient(outputs, self.q)

    def material(self) -> list[Node]:
        """Lower triangle by rows of the sum of weight times outer product of strain gradients."""
        return self._triangle(self.carried, geometric=False)

    def tangent(self) -> list[Node]:
        """Lower triangle of dQ/dq by rows."""
        return self._triangle(self.patches, geometric=True)

    def _triangle(self, patches: Sequence[Patch], *, geometric: bool) -> list[Node]:
        """Transform matrices from the variables of patches to the coordinates."""
        sums_of: Terms = {}
        for patch in patches:
            entries = self._second(patch, geometric=geometric)
            sums = {key: self.tape.linear(terms) for key, terms in entries.items()}
            inner = {key: node for key, node in sums.items() if self.tape.constant_value(node) != 0}
            for key, terms in project(self.tape, inner, patch.rows).items():
                sums_of.setdefault(key, []).extend(terms)
        inner = {key: self.tape.linear(terms) for key, terms in sums_of.items()}
        n = len(self.q)
        matrix = [*self.modes.matrix(), *({i: sp.Integer(1)} for i in range(n))]
        half = [[self._column(inner, matrix, m, j) for j in range(n)] for m in range(len(matrix))]
        result = []
        for i in range(n):
            for j in range(i + 1):
                terms = [(row[i], half[m][j]) for m, row in enumerate(matrix) if i in row]
                result.append(self.modes.form(terms))
        return result

    def _column(
        self, inner: Triangle, matrix: Sequence[dict[int, sp.Expr]], m: int, j: int
    ) -> Node:
        """Entry (m, j) of the product of a matrix in modes and their derivatives by coordinates."""
        terms = []
        for k, row in enumerate(matrix):
            node = inner.get((max(m, k), min(m, k)))
            if node is not None and j in row:
                terms.append((row[j], node))
        return self.modes.form(terms)

    def _second(self, patch: Patch, *, geometric: bool) -> Terms:
        """Second derivative of the energy of a patch by its own variables, lower triangle.

        Without the geometric part, only weight times the outer product of strain gradients.
        """
        tape = self.tape
        entries: Terms = {}
        frozen = []
        for weight, strain in patch.strains:
            slope = tape.gradient(strain, patch.variables)
            if geometric:
                stress = tape.freeze(tape.mul(weight, strain))
                frozen.append((Fraction(1), tape.mul(stress, strain)))
            for i, left in enumerate(slope):
                stiff = tape.mul(weight, left)
                for j, right in enumerate(slope[: i + 1]):
                    entries.setdefault((i, j), []).append((Fraction(1), tape.mul(stiff, right)))
        gradient = tape.gradient(tape.linear(frozen), patch.variables)
        for i, component in enumerate(gradient):
            for j, node in enumerate(tape.gradient(component, patch.variables[: i + 1])):
                entries.setdefault((i, j), []).append((Fraction(1), node))
        return entries


def project(tape: Tape, hessian: Triangle, rows: Sequence[Sequence[tuple[Fraction, int]]]) -> Terms:
    """Terms of the lower triangle of B^T H B for a constant matrix B with sparse rows."""
    columns: dict[int, list[tuple[Fraction, int]]] = {}
    for local, row in enumerate(rows):
        for value, i in row:
            columns.setdefault(i, []).append((value, local))
    result: Terms = {}
    for local, row in enumerate(rows):
        half = {}
        for j, column in columns.items():
            found = [(v, hessian.get((max(local, m), min(local, m)))) for v, m in column]
            terms = [(value, node) for value, node in found if node is not None]
            if terms:
                half[j] = tape.linear(terms)
        for value, i in row:
            for j, node in half.items():
                if j <= i:
                    result.setdefault((i, j), []).append((value, node))
    return result


def derive(element: Element) -> Program:
    """Derive all kernels of an element."""
    d = Derivation(element)
    tape = d.tape
    outputs = {name: tape.lowered(getattr(d, name)()) for name in element.kernels}
    derived: set[Node] = set()
    for nodes in outputs.values():
        derived.update(n for n in nodes if tape.level[n] == PARAMETER)
        for node in tape.reachable(nodes):
            if tape.level[node] > PARAMETER:
                derived.update(a for a in tape[node].args if tape.level[a] == PARAMETER)
    used = {tape[n].value for n in tape.reachable(derived) if tape[n].op == "parameter"}
    known = [*PARAMETERS, *(each.name for each in element.own), *element.reference]
    if unknown := sorted(used.difference(known)):
        raise ValueError(f"{element.name} uses {unknown[0]}, which is not among its own parameters")
    names = [name for name in known if name in used]
    return Program(element, tape, outputs, names, sorted(derived))
