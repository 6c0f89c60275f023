"""From SymPy expressions to nodes on a tape."""

from collections.abc import Mapping, Sequence
from fractions import Fraction

import sympy as sp

from codegen.declarations.fields import PARAMETERS, dot
from codegen.tape import Node, Tape

Scaled = tuple[sp.Expr, Node]
"""A factor in rationals and parameters, and the node it multiplies."""


def fraction(value: sp.Rational) -> Fraction:
    """Exact value of a SymPy rational."""
    return Fraction(int(value.p), int(value.q))


def to_tape(tape: Tape, expr: sp.Expr, values: Mapping[sp.Expr, Node]) -> Node:
    """Put an expression on the tape; symbols are found in `values` or are base parameters."""
    if expr in values:
        return values[expr]
    if expr.is_Rational:
        return tape.const(fraction(expr))
    if expr.is_Symbol:
        return tape.parameter(str(expr))
    if expr.is_Add:
        return tape.linear([(1, to_tape(tape, term, values)) for term in expr.args])
    if expr.is_Mul:
        coefficient, rest = expr.as_coeff_Mul()
        node = tape.const(1)
        for factor in sp.Mul.make_args(rest):
            node = tape.mul(node, to_tape(tape, factor, values))
        return tape.scale(fraction(coefficient), node)
    if expr.is_Pow and expr.exp.is_Rational:
        return tape.pow(to_tape(tape, expr.base, values), fraction(expr.exp))
    raise ValueError(f"the energy contains {expr}, which kernels cannot compute")


def affine(expr: sp.Expr) -> tuple[sp.Expr, list[tuple[sp.Expr, sp.Expr]]] | None:
    """Constant and coefficients of an affine form in dot products, components, strains; or None."""
    atoms = {a for a in expr.free_symbols if str(a) not in PARAMETERS}
    inside = {s for d in expr.atoms(dot) for s in d.args}
    ordered = sorted((atoms - inside) | expr.atoms(dot), key=str)
    terms = [(a, sp.diff(expr, a)) for a in ordered]
    if any(c.has(*ordered) for _, c in terms):
        return None
    return expr.subs({a: 0 for a in ordered}), terms


def combine(tape: Tape, members: Sequence[tuple[sp.Expr, Node]]) -> Scaled:
    """Sum of factor times node, with a common power of parameters factored out."""
    members = [(sp.sympify(factor), node) for factor, node in members if factor != 0]
    if not members:
        return sp.Integer(1), tape.const(0)
    common = members[0][0].as_coeff_Mul()[1]
    ratios = [(factor / common, node) for factor, node in members]
    if all(ratio.is_Rational for ratio, _ in ratios):
        return common, tape.linear([(fraction(ratio), node) for ratio, node in ratios])
    terms = [(1, tape.mul(to_tape(tape, factor, {}), node)) for factor, node in members]
    return sp.Integer(1), tape.linear(terms)
