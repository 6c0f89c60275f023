"""A contribution written in Python: `ancf_contribution` through ctypes."""

import ctypes as ct

_new_capsule = ct.pythonapi.PyCapsule_New
_new_capsule.restype = ct.py_object
_new_capsule.argtypes = [ct.c_void_p, ct.c_char_p, ct.c_void_p]

_NAME = b"ancf_contribution"
_NUMBERS = ct.POINTER(ct.c_double)


class _State(ct.Structure):
    """`ancf_state` of abi/solver_abi.h."""

    _fields_ = [(name, _NUMBERS) for name in ("q", "v", "a", "lam", "amplitudes")]


_STATE = ct.POINTER(_State)
_RESIDUAL = ct.CFUNCTYPE(None, ct.c_void_p, _STATE, _NUMBERS, _NUMBERS)
_SEE = ct.CFUNCTYPE(None, ct.c_void_p, _STATE)


class _Interface(ct.Structure):
    """`ancf_contribution` of abi/system_abi.h."""

    _fields_ = [
        ("context", ct.c_void_p),
        ("damped", ct.c_int),
        ("n_memory", ct.c_ssize_t),
        ("memory", _NUMBERS),
        ("residual", _RESIDUAL),
        *((name, ct.c_void_p) for name in ("between", "matrix", "inertia", "damping", "energy")),
        *((name, ct.c_void_p) for name in ("work", "reach")),
        ("begin", _SEE),
        ("accept", _SEE),
        *((name, ct.c_void_p) for name in ("rates", "tune")),
    ]


class Winch:
    """A force on a coordinate that grows by a newton with every accepted step.

    Parameters
    ----------
    place : int
        Of the coordinate in q.
    """

    def __init__(self, place):
        self.seen = []  # the coordinate at the start and after each accepted step
        self.calls = 0
        self._kept = (ct.c_double * 1)()

        def residual(_, state, r, phi):
            self.calls += 1
            r[place] -= self._kept[0]

        def begin(_, state):
            self._kept[0] = 0.0
            self.seen = [state[0].q[place]]

        def accept(_, state):
            self._kept[0] += 1.0
            self.seen.append(state[0].q[place])

        self._interface = _Interface(
            n_memory=1,
            memory=self._kept,
            residual=_RESIDUAL(residual),
            begin=_SEE(begin),
            accept=_SEE(accept),
        )
        self.capsule = _new_capsule(ct.addressof(self._interface), _NAME, None)
