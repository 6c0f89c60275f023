"""Equations written in Python that the compiled loop solves: `ancf_equations` through ctypes."""

import ctypes as ct

import numpy as np

from ancfsparse.dispatch import compiled_module
from ancfsparse.seeds import SparseSeed
from tests.headers import c_structure, implement

_pointer = ct.pythonapi.PyCapsule_GetPointer
_pointer.restype = ct.c_void_p
_pointer.argtypes = [ct.py_object, ct.c_char_p]


def nonlinear_of(loop):
    """Return the C interface of a loop."""
    return c_structure("ancf_nonlinear").from_address(_pointer(loop.capsule, b"ancf_nonlinear"))


class Equations:
    """r(x) = 0 from a predictor, with full lower triangles as matrices.

    Parameters
    ----------
    residual, jacobian : callable
        x (n,) to r (n,) and to a symmetric J (n, n).
    start : (n,) float
        Predictor.
    n_multipliers : int
        How many of the unknowns, the last ones, are multipliers.
    material : callable, optional
        x to a definite neighbour of J.
    coast : (n,) float, optional
        Another start.
    leap : (n,) float, optional
        The first start, in place of the predictor.
    """

    def __init__(
        self, residual, jacobian, start, n_multipliers=0, material=None, coast=None, leap=None
    ):
        self.start = np.array(start, dtype=float)
        self.x = self.start.copy()
        self.trace = []  # the names of the calls, in order
        n = len(self.x)
        self.n_coordinates = n - n_multipliers
        row, column = np.tril_indices(n)
        order = np.lexsort((row, column))
        self.row, self.column = row[order], column[order]
        self.indptr = np.searchsorted(self.column, np.arange(n + 1))

        def restart(_):
            self.trace.append("restart")
            self.x = np.array(leap, dtype=float) if self.interface.leaps else self.start.copy()

        def fly(_):
            self.trace.append("coast")
            self.x = np.array(coast, dtype=float)

        def correct(_, factor, s):
            self.trace.append("correct")
            with np.errstate(all="ignore"):  # a diverging loop may overflow
                change = factor * np.ctypeslib.as_array(s, (n,))
                self.x = self.x + change
                return np.sum(change[: self.n_coordinates] ** 2)

        def write_residual(_, r):
            self.trace.append("residual")
            with np.errstate(all="ignore"):
                np.ctypeslib.as_array(r, (n,))[:] = residual(self.x)
            return 0.0  # there are no masses

        def write_matrix(_, values):
            self.trace.append("matrix")
            values = np.ctypeslib.as_array(values, (len(self.row),))
            with np.errstate(all="ignore"):
                values[:] = jacobian(self.x)[self.row, self.column]

        def write_material(_, values):
            self.trace.append("material")
            values = np.ctypeslib.as_array(values, (len(self.row),))
            values[:] = material(self.x)[self.row, self.column]

        self.interface, self.capsule = implement(
            "ancf_equations", n=n, n_coordinates=self.n_coordinates, n_values=len(self.row),
            restart=restart, correct=correct, residual=write_residual, matrix=write_matrix,
            coast=coast and fly, material=material and write_material,
            mass_total=self.n_coordinates, leaps=leap is not None,
        )  # fmt: skip
        self.seed = SparseSeed(self.indptr, self.row.astype(np.int32), self.n_coordinates)

    def calls(self, name):
        return self.trace.count(name)

    def loop(self, inverse=None, **options):
        """The compiled loop: Newton unless an inverse is given."""
        settings = {
            "newton": inverse is None,
            "learns": inverse is not None,
            "carry": False,
            "polishes": False,
            "economical": False,
            "rounds": True,
            "by_correction": False,
            "max_iterations": 25,
            "force_tolerance": 1e-10,
            "constraint_tolerance": 1e-10,
            "correction_tolerance": 1e-10,
            "noise": 1e-16,
            "cost_iteration": 1.0,
            "cost_rotation": 0.0,
            "cost_seed": 10.0,
            "patience": 0.0,
            "rotating": False,
            "compares_frames": False,
        }
        if inverse is None:
            inverse = compiled_module("limited").Limited(self.seed, "broyden", 0)
        return compiled_module("iteration").Iteration(
            self, self.seed, inverse, None, **(settings | options)
        )

    def dense(self, rule):
        return compiled_module("dense").Dense(self.seed, rule)

    def limited(self, rule, n_pairs):
        return compiled_module("limited").Limited(self.seed, rule, n_pairs)


def between_wells(watch=None, **options):
    """Newton's method goes to and fro between 0 and 1, and damped it is caught at 0.8.

    All x whose residual is asked for are entered in a list.
    """
    seen = [] if watch is None else watch

    def residual(x):
        seen.append(float(x[0]))
        return x**3 - 2.0 * x + 2.0

    return Equations(residual, lambda x: np.diag(3.0 * x**2 - 2.0), [0.0], **options)


def spring(stiffness, n=1):
    """Springs at rest in 1, whose stiffness may change: a list of one number."""
    return Equations(
        lambda x: stiffness[0] * (x - 1.0), lambda x: stiffness[0] * np.eye(n), np.zeros(n)
    )
