"""Straight-line programs: equal expressions are one node, coefficients are exact until printed.

A node is a number, the index of its entry on the tape; its operands precede it.  Nodes are
classified as constants, dependent only on parameters, or dependent on coordinates, so that
everything that is constant during a motion can be computed once, outside the kernels.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

Node = int
Op = Literal[
    "const", "parameter", "coordinate", "acceleration",
    "add", "sub", "mul", "neg", "pow", "freeze", "sqrt", "reciprocal",
]  # fmt: skip
CONSTANT, PARAMETER, VARIABLE = 0, 1, 2
ARITHMETIC = ("add", "sub", "mul", "neg", "sqrt", "reciprocal")


@dataclass(frozen=True, slots=True)
class Entry:
    """One operation; `value` is a constant, an exponent, or the name of an input."""

    op: Op
    args: tuple[Node, ...] = ()
    value: Fraction | int | str = 0


class Tape:
    """Builds a program by hash-consing: the same operation always yields the same node."""

    def __init__(self) -> None:
        """Start empty."""
        self.entries: list[Entry] = []
        self.level: list[int] = []
        self._places: dict[Entry, Node] = {}

    def __getitem__(self, node: Node) -> Entry:
        """Operation of a node."""
        return self.entries[node]

    def _node(self, entry: Entry, level: int | None = None) -> Node:
        place = self._places.get(entry)
        if place is None:
            place = len(self.entries)
            self._places[entry] = place
            self.entries.append(entry)
            self.level.append(max(self.level[a] for a in entry.args) if level is None else level)
        return place

    # Leaves

    def const(self, value: Fraction | int) -> Node:
        """Exact number."""
        return self._node(Entry("const", value=Fraction(value)), CONSTANT)

    def parameter(self, name: str) -> Node:
        """Parameter of the element, by name."""
        return self._node(Entry("parameter", value=name), PARAMETER)

    def coordinate(self, number: int) -> Node:
        """Coordinate of the element, by its index."""
        return self._node(Entry("coordinate", value=number), VARIABLE)

    def acceleration(self, number: int) -> Node:
        """Second time derivative of a coordinate."""
        return self._node(Entry("acceleration", value=number), VARIABLE)

    # Operations

    def constant_value(self, node: Node) -> Fraction | None:
        """Value of a constant, None for other nodes."""
        entry = self.entries[node]
        return entry.value if entry.op == "const" and isinstance(entry.value, Fraction) else None

    def split(self, node: Node) -> tuple[Fraction, Node]:
        """Split a node into an exact coefficient and a node without one."""
        entry = self.entries[node]
        if entry.op == "neg":
            coefficient, rest = self.split(entry.args[0])
            return -coefficient, rest
        if entry.op == "const":
            return self._value(node), self.const(1)
        if entry.op == "mul" and self.entries[entry.args[0]].op == "const":
            return self._value(entry.args[0]), entry.args[1]
        return Fraction(1), node

    def _value(self, node: Node) -> Fraction:
        value = self.entries[node].value
        assert isinstance(value, Fraction)
        return value

    def neg(self, a: Node) -> Node:
        """Minus a node; two signs cancel, a difference is reversed."""
        entry = self.entries[a]
        if entry.op == "neg":
            return entry.args[0]
        if entry.op == "const":
            return self.const(-self._value(a))
        if entry.op == "sub":
            return self._node(Entry("sub", (entry.args[1], entry.args[0])))
        return self._node(Entry("neg", (a,)))

    def scale(self, coefficient: Fraction | int, a: Node) -> Node:
        """Coefficient times node, with one positive constant in front and the sign outside."""
        inner, rest = self.split(a)
        total = Fraction(coefficient) * inner
        if total == 0 or self.constant_value(rest) is not None:
            return self.const(total)
        node = rest if abs(total) == 1 else self._node(Entry("mul", (self.const(abs(total)), rest)))
        return node if total > 0 else self.neg(node)

    def mul(self, a: Node, b: Node) -> Node:
        """Product, its constant coefficient in front."""
        left, a = self.split(a)
        right, b = self.split(b)
        if self.constant_value(a) is not None or self.constant_value(b) is not None:
            return self.scale(left * right, b if self.constant_value(a) is not None else a)
        return self.scale(left * right, self._node(Entry("mul", (min(a, b), max(a, b)))))

    def add(self, a: Node, b: Node) -> Node:
        """Sum of two nodes."""
        return self.linear([(Fraction(1), a), (Fraction(1), b)])

    def linear(self, terms: Iterable[tuple[Fraction | int, Node]]) -> Node:
        """Sum of coefficient times node; equal coefficients share one multiplication."""
        total: dict[Node, Fraction] = {}
        for outer, node in terms:
            inner, rest = self.split(node)
            total[rest] = total.get(rest, Fraction(0)) + outer * inner
        kept = sorted((node, value) for node, value in total.items() if value != 0)
        if not kept:
            return self.const(0)
        sign = 1 if kept[0][1] > 0 else -1
        groups: dict[Fraction, list[tuple[int, Node]]] = {}
        for node, value in kept:
            groups.setdefault(abs(value), []).append((sign if value > 0 else -sign, node))
        parts = []
        for size, members in groups.items():
            flip = members[0][0]
            inner_sum = self._chain([(flip * s, node) for s, node in members])
            one = self.constant_value(inner_sum) is not None
            part = self.const(size * self._value(inner_sum)) if one else self.scale(size, inner_sum)
            parts.append((flip, part))
        result = self._chain(parts)
        return result if sign > 0 else self.neg(result)

    def _chain(self, signed: Sequence[tuple[int, Node]]) -> Node:
        """Sum from left to right; the first sign is plus."""
        result = signed[0][1]
        for sign, node in signed[1:]:
            if self.entries[node].op == "neg":
                sign, node = -sign, self.entries[node].args[0]
            if self.entries[result].op == "neg":
                other = self.entries[result].args[0]
                if sign > 0:
                    result = self._node(Entry("sub", (node, other)))
                else:
                    result = self.neg(
                        self._node(Entry("add", (min(other, node), max(other, node))))
                    )
            elif sign > 0:
                result = self._node(Entry("add", (min(result, node), max(result, node))))
            else:
                result = self._node(Entry("sub", (result, node)))
        return result

    def pow(self, a: Node, exponent: Fraction) -> Node:
        """Power with an exact exponent; positive integer powers are products."""
        if exponent == 0:
            return self.const(1)
        if exponent == 1:
            return a
        if exponent.denominator == 1 and exponent > 1:
            return self.mul(a, self.pow(a, exponent - 1))
        value = self.constant_value(a)
        if value is not None and exponent.denominator == 1:
            return self.const(value**exponent.numerator)
        return self._node(Entry("pow", (a,), exponent))

    def freeze(self, a: Node) -> Node:
        """Mark a value as constant in differentiation."""
        return a if self.level[a] < VARIABLE else self._node(Entry("freeze", (a,)))

    def sqrt(self, a: Node) -> Node:
        """Square root."""
        return self._node(Entry("sqrt", (a,)))

    def reciprocal(self, a: Node) -> Node:
        """Reciprocal of a node."""
        return self._node(Entry("reciprocal", (a,)))

    def dot(self, u: Sequence[Node], v: Sequence[Node]) -> Node:
        """Sum of products."""
        return self.linear([(1, self.mul(a, b)) for a, b in zip(u, v, strict=True)])

    # Programs

    def reachable(self, outputs: Iterable[Node]) -> list[Node]:
        """Nodes the outputs need, operands first."""
        wanted = set(outputs)
        for node in range(max(wanted, default=-1), -1, -1):
            if node in wanted:
                wanted.update(self.entries[node].args)
        return sorted(wanted)

    def operations(self, outputs: Iterable[Node]) -> int:
        """Count arithmetic on coordinates; operations on parameters only are not counted."""
        return sum(
            self.entries[n].op in ARITHMETIC and self.level[n] == VARIABLE
            for n in self.reachable(outputs)
        )

    def gradient(self, output: Node, variables: Sequence[Node]) -> list[Node]:
        """Reverse pass: derivative of the output by each variable, which is treated as a leaf."""
        leaves = set(variables)
        depends: dict[Node, bool] = {}
        order = self.reachable([output])
        for node in order:
            entry = self.entries[node]
            below = entry.op != "freeze" and any(depends[a] for a in entry.args)
            depends[node] = node in leaves or below
        adjoint: dict[Node, list[tuple[Fraction, Node]]] = {n: [] for n in order if depends[n]}
        if not depends[output]:
            return [self.const(0)] * len(variables)
        adjoint[output].append((Fraction(1), self.const(1)))
        result: dict[Node, Node] = {}
        for node in reversed(order):
            if not depends[node]:
                continue
            mine = self.linear(adjoint.pop(node))
            if node in leaves:
                result[node] = mine
                continue
            for operand, factor in self._partials(node):
                if depends[operand]:
                    adjoint[operand].append((Fraction(1), self.mul(factor, mine)))
        return [result.get(v, self.const(0)) for v in variables]

    def directional(self, outputs: Sequence[Node], along: Mapping[Node, Node]) -> list[Node]:
        """Forward pass: rates of the outputs if the leaves change at the rates in `along`."""
        rates: dict[Node, Node] = {}
        for node in self.reachable(outputs):
            if node in along:
                rates[node] = along[node]
            elif self.entries[node].args and self.entries[node].op != "freeze":
                partials = [(a, factor) for a, factor in self._partials(node) if a in rates]
                if partials:
                    terms = [(1, self.mul(factor, rates[a])) for a, factor in partials]
                    rates[node] = self.linear(terms)
        return [rates.get(node, self.const(0)) for node in outputs]

    def _partials(self, node: Node) -> list[tuple[Node, Node]]:
        entry = self.entries[node]
        if entry.op == "add":
            return [(entry.args[0], self.const(1)), (entry.args[1], self.const(1))]
        if entry.op == "sub":
            return [(entry.args[0], self.const(1)), (entry.args[1], self.const(-1))]
        if entry.op == "neg":
            return [(entry.args[0], self.const(-1))]
        if entry.op == "mul":
            a, b = entry.args
            return [(a, self.scale(2, a))] if a == b else [(a, b), (b, a)]
        if entry.op == "pow" and isinstance(entry.value, Fraction):
            power = self.pow(entry.args[0], entry.value - 1)
            return [(entry.args[0], self.scale(entry.value, power))]
        raise ValueError(f"the operation {entry.op!r} has no derivative rule")

    def lowered(self, outputs: Sequence[Node]) -> list[Node]:
        """Replace `freeze` by its operand and powers by one root, one division and products."""
        order = self.reachable(outputs)
        with_root = {
            self.entries[n].args[0]
            for n in order
            if self.entries[n].op == "pow" and Fraction(self.entries[n].value).denominator == 2
        }
        new: dict[Node, Node] = {}
        for node in order:
            entry = self.entries[node]
            args = tuple(new[a] for a in entry.args)
            if entry.op == "pow":
                has_root = entry.args[0] in with_root
                new[node] = self._power(args[0], Fraction(entry.value), has_root)
            elif entry.op == "freeze":
                new[node] = args[0]
            elif entry.op == "mul":
                new[node] = self.mul(*args)
            elif entry.op in ("add", "sub"):
                new[node] = self._chain([(1, args[0]), (1 if entry.op == "add" else -1, args[1])])
            elif entry.op == "neg":
                new[node] = self.neg(args[0])
            else:
                new[node] = node
        return [new[n] for n in outputs]

    def _power(self, base: Node, exponent: Fraction, with_root: bool) -> Node:
        half = Fraction(1, 2)
        if exponent == half:
            return self.sqrt(base)
        if exponent == -half:
            return self.reciprocal(self.sqrt(base))
        if exponent == -1:
            if not with_root:
                return self.reciprocal(base)
            root = self._power(base, -half, with_root)
            return self.mul(root, root)
        step = Fraction(1) if exponent > 0 else Fraction(-1)
        factor = base if exponent > 0 else self._power(base, Fraction(-1), with_root)
        return self.mul(self._power(base, exponent - step, with_root), factor)
