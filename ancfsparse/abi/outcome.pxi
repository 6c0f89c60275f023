"""Declarations of the enumerations in outcome.h."""

cdef extern from "outcome.h":
    enum:
        CONVERGED "ANCF_CONVERGED"
        TOO_MANY "ANCF_TOO_MANY"
        DIVERGED "ANCF_DIVERGED"
        NOT_FINITE "ANCF_NOT_FINITE"
        GAINED_ENERGY "ANCF_GAINED_ENERGY"
        INDEFINITE "ANCF_INDEFINITE"
        WOULD_GAIN "ANCF_WOULD_GAIN"
        PASSES_THROUGH "ANCF_PASSES_THROUGH"
    ctypedef enum Rung "enum ancf_rung":
        METHOD "ANCF_METHOD"
        NEW_SEED "ANCF_NEW_SEED"
        DAMPED_NEWTON "ANCF_DAMPED_NEWTON"
        NEWTON "ANCF_NEWTON"
        COASTING "ANCF_COASTING"
        DESCENT "ANCF_DESCENT"
        LONG_NEWTON "ANCF_LONG_NEWTON"
