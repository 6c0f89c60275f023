"""Equations written in Python that the compiled loop solves: `ancf_equations` through ctypes."""

import ctypes as ct

import numpy as np

from ancfsparse.dispatch import compiled_module
from ancfsparse.seeds import SparseSeed

_new_capsule = ct.pythonapi.PyCapsule_New
_new_capsule.restype = ct.py_object
_new_capsule.argtypes = [ct.c_void_p, ct.c_char_p, ct.c_void_p]

_NAME = b"ancf_equations"
_NUMBERS = ct.POINTER(ct.c_double)
_DO = ct.CFUNCTYPE(None, ct.c_void_p)
_PASS = ct.CFUNCTYPE(None, ct.c_void_p, _NUMBERS)
_RESIDUAL = ct.CFUNCTYPE(ct.c_double, ct.c_void_p, _NUMBERS)
_CORRECT = ct.CFUNCTYPE(ct.c_double, ct.c_void_p, ct.c_double, _NUMBERS)


class _Interface(ct.Structure):
    """`ancf_equations` of abi/solver_abi.h."""

    _fields_ = [
        ("context", ct.c_void_p),
        ("n", ct.c_ssize_t),
        ("n_coordinates", ct.c_ssize_t),
        ("n_values", ct.c_ssize_t),
        ("restart", _DO),
        ("coast", _DO),
        ("correct", _CORRECT),
        ("residual", _RESIDUAL),
        ("matrix", _PASS),
        ("material", _PASS),
        ("q", ct.c_void_p),
        ("mass", ct.c_void_p),
        ("inverse_mass", ct.c_void_p),
        ("mass_total", ct.c_double),
        ("moved", ct.c_double),
        ("shift", ct.c_double),
        ("leaps", ct.c_int),
        ("sudden", ct.c_int),
    ]


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
    """

    def __init__(self, residual, jacobian, start, n_multipliers=0, material=None, coast=None):
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
            self.x = self.start.copy()

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

        self.interface = _Interface(
            None, n, self.n_coordinates, len(self.row),
            _DO(restart), _DO() if coast is None else _DO(fly), _CORRECT(correct),
            _RESIDUAL(write_residual), _PASS(write_matrix),
            _PASS() if material is None else _PASS(write_material), None,
            None, None, self.n_coordinates, 0.0,
        )  # fmt: skip
        self.capsule = _new_capsule(ct.addressof(self.interface), _NAME, None)
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
