"""Declarations of the structure documented in system_abi.h; an include file."""
include "solver_abi.pxi"

cdef extern from "system_abi.h":
    enum Part "ancf_part":
        STIFFNESS "ANCF_STIFFNESS"
        MATERIAL "ANCF_MATERIAL"
        DAMPING "ANCF_DAMPING"
        MASS "ANCF_MASS"
        EQUATIONS "ANCF_EQUATIONS"
        EQUATION_MASS "ANCF_EQUATION_MASS"

    ctypedef struct ancf_contribution:
        void *context
        int damped
        ptrdiff_t n_memory
        double *memory
        ptrdiff_t n_history
        void (*residual)(void *, const ancf_state *, double *, double *) noexcept nogil
        void (*between)(void *, const double *, const double *, const ancf_state *, double *,
                        double *) noexcept nogil
        void (*matrix)(void *, int, const ancf_state *, double *) noexcept nogil
        void (*inertia)(void *, const double *, double *) noexcept nogil
        void (*damping)(void *, const double *, const double *, double *) noexcept nogil
        double (*energy)(void *, const double *) noexcept nogil
        double (*work)(void *, const ancf_state *, const ancf_state *, double *) noexcept nogil
        double (*reach)(void *, const double *, const double *, const double *,
                        double *) noexcept nogil
        void (*begin)(void *, const ancf_state *) noexcept nogil
        void (*accept)(void *, const ancf_state *) noexcept nogil
        void (*set_step)(void *, double) noexcept nogil
        void (*rates)(void *, const double *, const double *, double *, double *) noexcept nogil
        void (*tune)(void *, const double *) noexcept nogil
        int (*admits)(void *, const double *, const double *) noexcept nogil
        int (*contacts_changed)(void *) noexcept nogil
        void (*add_impulses)(void *, double) noexcept nogil
        int (*end_impulses)(void *, double, const ancf_state *, const ancf_state *, double *,
                            double *) noexcept nogil
