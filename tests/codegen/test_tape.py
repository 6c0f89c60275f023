"""The tape against SymPy: values, folding, derivatives, lowering of powers."""

from fractions import Fraction

import pytest
import sympy as sp

from codegen.symbols import to_tape
from codegen.tape import Tape

x, y, z = sp.symbols("x y z", real=True)
POINT = {x: sp.Rational(3, 7), y: sp.Rational(-5, 3), z: sp.Rational(11, 13)}
EXPRESSIONS = [
    x * y + z - 2,
    (x + y) ** 3 - sp.Rational(2, 3) * (x + y) ** 2,
    (x * y - z**2) / (x**2 + y**2 + z**2),
    (x - y) * (x**2 + z**2) ** sp.Rational(-3, 2),
    sp.sqrt(x**2 + y**2) - 1,
    -3 * (x - 2 * (y - z)) * x,
]


def on_tape(expr):
    tape = Tape()
    values = {symbol: tape.coordinate(i) for i, symbol in enumerate((x, y, z))}
    return tape, to_tape(tape, expr, values), list(values.values())


def evaluate(tape, node):
    """Value of a node at POINT, exact."""
    inputs = list(POINT.values())
    values = {}
    for n in tape.reachable([node]):
        entry = tape[n]
        args = [values[a] for a in entry.args]
        values[n] = {
            "const": lambda e=entry: sp.Rational(e.value),
            "coordinate": lambda e=entry: inputs[e.value],
            "add": lambda a=args: a[0] + a[1],
            "sub": lambda a=args: a[0] - a[1],
            "mul": lambda a=args: a[0] * a[1],
            "neg": lambda a=args: -a[0],
            "pow": lambda a=args, e=entry: a[0] ** sp.Rational(e.value),
            "freeze": lambda a=args: a[0],
            "sqrt": lambda a=args: sp.sqrt(a[0]),
            "reciprocal": lambda a=args: 1 / a[0],
        }[entry.op]()
    return values[node]


def same(a, b):
    return abs(sp.N(a - b, 30)) < 1e-25


@pytest.mark.parametrize("expr", EXPRESSIONS)
def test_value_gradient_and_second_derivative(expr):
    tape, node, variables = on_tape(expr)
    assert same(evaluate(tape, node), expr.subs(POINT))
    slope = tape.gradient(node, variables)
    for symbol, component in zip(POINT, slope, strict=True):
        assert same(evaluate(tape, component), sp.diff(expr, symbol).subs(POINT))
        for other, second in zip(POINT, tape.gradient(component, variables), strict=True):
            assert same(evaluate(tape, second), sp.diff(expr, symbol, other).subs(POINT))


@pytest.mark.parametrize("expr", EXPRESSIONS)
def test_rate_is_the_sum_of_partial_derivatives_times_rates(expr):
    tape, node, variables = on_tape(expr)
    speeds = [Fraction(2, 3), Fraction(-7, 5), Fraction(0)]
    along = {v: tape.const(s) for v, s in zip(variables, speeds, strict=True)}
    expected = sum(
        sp.Rational(s.numerator, s.denominator) * sp.diff(expr, symbol).subs(POINT)
        for symbol, s in zip(POINT, speeds, strict=True)
    )
    square = tape.mul(node, node)
    found, twice = tape.directional([node, square], along)
    assert same(evaluate(tape, found), expected)
    assert same(evaluate(tape, twice), 2 * expected * expr.subs(POINT))


@pytest.mark.parametrize("expr", EXPRESSIONS)
def test_lowering_keeps_the_value(expr):
    tape, node, variables = on_tape(expr)
    outputs = [node, *tape.gradient(node, variables)]
    lowered = tape.lowered(outputs)
    assert not {tape[n].op for n in tape.reachable(lowered)} & {"pow", "freeze"}
    for before, after in zip(outputs, lowered, strict=True):
        assert same(evaluate(tape, before), evaluate(tape, after))


def test_one_root_and_one_division_serve_all_powers():
    tape, node, variables = on_tape((x - y) * (x**2 + z**2) ** sp.Rational(-3, 2))
    order = tape.reachable(tape.lowered(tape.gradient(node, variables)))
    ops = [tape[n].op for n in order]
    assert ops.count("sqrt") == ops.count("reciprocal") == 1


def test_equal_expressions_are_one_node():
    tape = Tape()
    a, b = tape.coordinate(0), tape.coordinate(1)
    assert tape.add(a, b) == tape.add(b, a)
    assert tape.mul(tape.neg(a), b) == tape.neg(tape.mul(a, b))
    assert tape.linear([(1, a), (-1, b)]) == tape.neg(tape.linear([(-1, a), (1, b)]))
    assert tape.scale(Fraction(1, 2), tape.scale(2, a)) == a


def test_constants_fold_exactly():
    tape = Tape()
    a = tape.coordinate(0)
    third = tape.const(Fraction(1, 3))
    assert tape.linear([(3, third), (-1, tape.const(1))]) == tape.const(0)
    assert tape.mul(a, tape.const(0)) == tape.const(0)
    assert tape.linear([(2, a), (-2, a), (5, third)]) == tape.const(Fraction(5, 3))


def test_equal_coefficients_share_a_multiplication():
    tape = Tape()
    a, b, c = (tape.coordinate(i) for i in range(3))
    total = tape.linear([(Fraction(1, 3), a), (Fraction(-1, 3), b), (1, c)])
    assert tape.operations([total]) == 3


def test_frozen_values_have_no_derivative():
    tape = Tape()
    a = tape.coordinate(0)
    product = tape.mul(tape.freeze(tape.mul(a, a)), a)
    assert tape.lowered(tape.gradient(product, [a])) == [tape.mul(a, a)]
    assert tape.lowered(tape.directional([product], {a: tape.const(2)})) == [
        tape.scale(2, tape.mul(a, a))
    ]


def test_parameters_cost_nothing_in_kernels():
    tape = Tape()
    a, p = tape.coordinate(0), tape.parameter("length")
    weight = tape.mul(tape.pow(p, Fraction(-2)), tape.parameter("axial_stiffness"))
    assert tape.operations([tape.mul(weight, a)]) == 1
