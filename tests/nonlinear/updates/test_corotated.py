"""An inverse in the axes of its seed against R H R^T written out."""

import numpy as np
import pytest

from ancfsparse.dispatch import compiled_module
from tests.nonlinear.formulas import UPDATES
from tests.nonlinear.updates.drive import Problem, dense, iterate, limited, matrix_of

N_NODES, M = 6, 3
N = 4 * N_NODES


def planar_frame():
    """Of N_NODES nodes with a position and a slope, and M multipliers behind them."""
    places = np.arange(N, dtype=np.int32).reshape(N_NODES, 4)
    rows = np.arange(N_NODES, dtype=np.int32)
    return compiled_module("rotation").Frame(
        N + M,
        np.ascontiguousarray(places[:, 2:]),
        np.zeros(1, np.int32),
        np.zeros(0, np.int32),
        np.concatenate([places[:, :2], places[:, 2:]]),
        np.concatenate([rows, rows]),
    )


def turn(frame, angles):
    """Turn every node by its angle from the x axis; return R."""
    q = np.zeros(N)
    q[2::4] = 1.0
    frame.hold(q)
    q[2::4], q[3::4] = np.cos(angles), np.sin(angles)
    frame.turn(q)
    r = np.eye(N + M)
    for node, angle in enumerate(angles):
        c, s = np.cos(angle), np.sin(angle)
        for first in (4 * node, 4 * node + 2):
            r[first : first + 2, first : first + 2] = [[c, -s], [s, c]]
    return r


def problem_of(rng):
    return Problem(rng, n=N, m=M)


@pytest.mark.parametrize("make", [dense, limited])
def test_a_product_is_turned_back_and_forth(make, rng):
    problem, frame = problem_of(rng), planar_frame()
    inverse = compiled_module("corotated").Corotated(make("broyden", problem.a, N), frame)
    np.testing.assert_allclose(matrix_of(inverse, N + M), problem.h0, rtol=0, atol=1e-11)
    r = turn(frame, rng.uniform(-3.0, 3.0, N_NODES))
    expected = r @ problem.h0 @ r.T
    np.testing.assert_allclose(matrix_of(inverse, N + M), expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("make", [dense, limited])
@pytest.mark.parametrize("rule", UPDATES)
def test_pairs_turn_with_the_seed(rule, make, rng):
    # Learned under one rotation, used under another: R2 R1^T H R1 R2^T, with the H that the dense
    # formulas make of R1 H0 R1^T and the pairs as they were seen.
    problem, frame = problem_of(rng), planar_frame()
    inner = make(rule, problem.a, N)
    inverse = compiled_module("corotated").Corotated(inner, frame)
    r1 = turn(frame, rng.uniform(-0.1, 0.1, N_NODES))
    _, s_list, y_list = iterate(inverse, problem.residual, np.zeros(N + M), 3)
    expected = r1 @ problem.h0 @ r1.T
    for s, y in zip(s_list, y_list, strict=True):
        expected = UPDATES[rule](expected, s, y)
    found = matrix_of(inverse, N + M)
    size = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * size)
    r2 = turn(frame, rng.uniform(-3.0, 3.0, N_NODES))
    expected = r2 @ r1.T @ expected @ r1 @ r2.T
    np.testing.assert_allclose(matrix_of(inverse, N + M), expected, rtol=0, atol=1e-9 * size)


def test_frame_and_inverse_must_fit(rng):
    problem = Problem(rng, n=8, m=0)
    with pytest.raises(ValueError, match="differ in size"):
        compiled_module("corotated").Corotated(limited("broyden", problem.a, 8), planar_frame())
