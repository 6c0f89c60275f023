"""Discrete gradients of expressions against their differences and derivatives, exact."""

from fractions import Fraction

import pytest
import sympy as sp

from codegen.discrete_gradient import DiscreteGradient
from codegen.symbols import to_tape
from codegen.tape import Tape
from tests.codegen.test_tape import EXPRESSIONS, POINT, evaluate, on_tape, same, x, y, z

LATER = {x: sp.Rational(8, 5), y: sp.Rational(1, 9), z: sp.Rational(-2, 7)}
RATIONAL = [*EXPRESSIONS, (x + y**2 + 3) ** -2, (x**2 + y**2) ** sp.Rational(-5, 2) * z]


def discrete(expr, later):
    """The discrete gradient from POINT to another one."""
    tape, node, variables = on_tape(expr)
    there = [tape.const(Fraction(int(v.p), int(v.q))) for v in later.values()]
    discrete = DiscreteGradient(tape, dict(zip(variables, there, strict=True)))
    return [
        evaluate(tape, n) for n in discrete.gradient([(tape.const(1), node)], variables)
    ], evaluate(tape, discrete.later(node))


@pytest.mark.parametrize("expr", RATIONAL)
def test_times_the_way_it_is_the_difference(expr):
    found, there = discrete(expr, LATER)
    way = [LATER[symbol] - POINT[symbol] for symbol in POINT]
    assert same(there, expr.subs(LATER))
    assert same(
        sum(a * b for a, b in zip(found, way, strict=True)), expr.subs(LATER) - expr.subs(POINT)
    )


@pytest.mark.parametrize("expr", RATIONAL)
def test_without_a_way_it_is_the_gradient(expr):
    found, _ = discrete(expr, POINT)
    for symbol, component in zip(POINT, found, strict=True):
        assert same(component, sp.diff(expr, symbol).subs(POINT))


def test_factors_are_taken_as_they_are():
    tape, node, variables = on_tape(x * y)
    discrete = DiscreteGradient(tape, {variables[0]: tape.const(2), variables[1]: tape.const(5)})
    twice = discrete.gradient([(tape.const(2), node), (tape.const(3), variables[2])], variables)
    assert [evaluate(tape, n) for n in twice] == [
        POINT[y] + 5, POINT[x] + 2, 3,
    ]  # fmt: skip


def test_a_cube_root_is_refused():
    tape = Tape()
    q = tape.coordinate(0)
    node = to_tape(tape, sp.cbrt(x), {x: q})
    with pytest.raises(ValueError, match="power 1/3"):
        DiscreteGradient(tape, {q: tape.const(2)}).gradient([(tape.const(1), node)], [q])
