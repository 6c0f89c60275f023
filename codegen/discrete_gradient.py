"""Discrete gradients of a program between two states.

A discrete gradient DU(q0, q1) satisfies DU . (q1 - q0) = U(q1) - U(q0) and is the gradient if both
states coincide.  It is computed by a reverse pass in which every operation uses, instead of its
derivative, a difference quotient in closed form: a product xy uses the means of y and x, a root
1 / (sqrt(x0) + sqrt(x1)), and so on.  Nothing is divided by q1 - q0, so there is no cancellation if
the states are close.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from codegen.tape import Node, Tape

HALF = Fraction(1, 2)


class DiscreteGradient:
    """Two states of the leaves of a tape: the leaves themselves, and their nodes in `later`."""

    def __init__(self, tape: Tape, later: Mapping[Node, Node]) -> None:
        self.tape = tape
        self._later = dict(later)

    def later(self, node: Node) -> Node:
        """Return the node at the second state."""
        if node not in self._later:
            entry = self.tape[node]
            args = [self.later(a) for a in entry.args]
            self._later[node] = self._again(node, args) if args else node
        return self._later[node]

    def _again(self, node: Node, args: Sequence[Node]) -> Node:
        tape, entry = self.tape, self.tape[node]
        if entry.op == "mul":
            return tape.mul(*args)
        if entry.op in ("add", "sub"):
            return tape.linear([(1, args[0]), (1 if entry.op == "add" else -1, args[1])])
        if entry.op == "neg":
            return tape.neg(args[0])
        if entry.op == "pow":
            return tape.pow(args[0], Fraction(entry.value))
        raise ValueError(f"the operation {entry.op!r} has no rule for differences")

    def mean(self, node: Node) -> Node:
        """Return the mean of a node over the two states."""
        return self.tape.linear([(HALF, node), (HALF, self.later(node))])

    def gradient(
        self, outputs: Sequence[tuple[Node, Node]], variables: Sequence[Node]
    ) -> list[Node]:
        """Return the discrete gradient of a sum by each variable; variables are treated as leaves.

        Parameters
        ----------
        outputs : sequence of pairs of nodes
            Terms: a factor, treated as constant, and the node it multiplies.
        variables : sequence of nodes
            Leaves.
        """
        tape, leaves = self.tape, set(variables)
        order = tape.reachable([node for _, node in outputs])
        depends: dict[Node, bool] = {}
        for node in order:
            depends[node] = node in leaves or any(depends[a] for a in tape[node].args)
        adjoint: dict[Node, list[tuple[int, Node]]] = {n: [] for n in order if depends[n]}
        for factor, node in outputs:
            if depends[node]:
                adjoint[node].append((1, factor))
        result: dict[Node, Node] = {}
        for node in reversed(order):
            if not depends[node]:
                continue
            mine = tape.linear(adjoint.pop(node))
            if node in leaves:
                result[node] = mine
                continue
            for operand, quotient in self._quotients(node):
                if depends[operand]:
                    adjoint[operand].append((1, tape.mul(quotient, mine)))
        return [result.get(v, tape.const(0)) for v in variables]

    def _quotients(self, node: Node) -> list[tuple[Node, Node]]:
        """Return the difference quotient of the node by each operand."""
        tape, entry = self.tape, self.tape[node]
        if entry.op in ("add", "sub"):
            sign = 1 if entry.op == "add" else -1
            return [(entry.args[0], tape.const(1)), (entry.args[1], tape.const(sign))]
        if entry.op == "neg":
            return [(entry.args[0], tape.const(-1))]
        if entry.op == "mul":
            a, b = entry.args
            if a == b:
                return [(a, tape.add(a, self.later(a)))]
            return [(a, self.mean(b)), (b, self.mean(a))]
        if entry.op == "pow":
            return [(entry.args[0], self._power(entry.args[0], Fraction(entry.value)))]
        raise ValueError(f"the operation {entry.op!r} has no rule for differences")

    def _power(self, base: Node, exponent: Fraction) -> Node:
        """Return (x1^p - x0^p) / (x1 - x0); x^p is an integer power k of x, 1/x, or a root.

        y1^k - y0^k = (y1 - y0) sum of y0^i y1^j over i + j = k - 1.
        """
        tape = self.tape
        if exponent.denominator not in (1, 2):
            raise ValueError(f"the power {exponent} has no rule for differences")
        sign = 1 if exponent > 0 else -1
        unit = Fraction(sign, exponent.denominator)
        k = abs(exponent.numerator)
        ends = [tape.pow(x, unit) for x in (base, self.later(base))]
        if exponent.denominator == 2:
            roots = [tape.pow(x, HALF) for x in (base, self.later(base))]
            quotient = tape.pow(tape.add(*roots), Fraction(-1))
        else:
            quotient = tape.const(1)
        if sign < 0:
            quotient = tape.neg(tape.mul(quotient, tape.mul(*ends)))
        powers = [
            tape.mul(tape.pow(ends[0], Fraction(i)), tape.pow(ends[1], Fraction(k - 1 - i)))
            for i in range(k)
        ]
        return tape.mul(quotient, tape.linear([(1, power) for power in powers]))
