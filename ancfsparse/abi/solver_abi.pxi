"""Declarations of the structures documented in solver_abi.h; an include file."""
from libc.stdint cimport int32_t

cdef extern from "solver_abi.h":
    ctypedef struct ancf_state:
        const double *q
        const double *v
        const double *a
        const double *lam
        const double *amplitudes

    ctypedef struct ancf_system:
        void *context
        ptrdiff_t n_free, n_all, n_multipliers, n_values, n_amplitudes
        int damped
        void (*residual)(void *, const double *, const double *, const double *, const double *,
                         const double *, const double *, double *, double *) noexcept nogil
        void (*matrix)(void *, double, double, double, const double *, const double *,
                       const double *, const double *, double *) noexcept nogil
        void (*material)(void *, double, double, double, const double *,
                         double *) noexcept nogil
        void (*inertia)(void *, const double *, double *) noexcept nogil
        void (*energies)(void *, const double *, const double *, const double *, double *,
                         double *) noexcept nogil
        double (*load_work)(void *, const ancf_state *, const ancf_state *, double *) noexcept nogil
        double (*load_reach)(void *, const double *, const double *, const double *,
                             double *) noexcept nogil
        void (*residual_between)(void *, const double *, const double *, const double *,
                                 const double *, const double *, const double *, const double *,
                                 const double *, double *, double *) noexcept nogil
        void (*begin)(void *, const ancf_state *) noexcept nogil
        void (*accept)(void *, const ancf_state *) noexcept nogil
        ptrdiff_t n_history
        void (*history)(void *, double *) noexcept nogil
        void (*set_step)(void *, double) noexcept nogil
        int (*admits)(void *, const double *, const double *) noexcept nogil
        int (*contacts_changed)(void *) noexcept nogil
        void (*add_impulses)(void *, double) noexcept nogil
        int (*end_impulses)(void *, double, const ancf_state *, const ancf_state *, double *,
                            double *) noexcept nogil
        void (*add)(void *, double, const double *, double *) noexcept nogil

    ctypedef struct ancf_coupling:
        ptrdiff_t n, size, first, changes
        int used
        const int32_t *pair

    ctypedef struct ancf_seed:
        void *context
        ptrdiff_t n
        ptrdiff_t (*factor)(void *, const double *) noexcept nogil
        void (*solve)(void *, const double *, double *) noexcept nogil
        void (*round_to_single)(void *) noexcept nogil
        int (*mend)(void *, const double *) noexcept nogil
        int (*refine)(void *, double) noexcept nogil
        const double *extra
        void (*inverse)(void *, double *, ptrdiff_t, double *) noexcept nogil

    ctypedef struct ancf_equations:
        void *context
        ptrdiff_t n, n_coordinates, n_values
        void (*restart)(void *) noexcept nogil
        void (*coast)(void *) noexcept nogil
        double (*correct)(void *, double, const double *) noexcept nogil
        double (*residual)(void *, double *) noexcept nogil
        void (*matrix)(void *, double *) noexcept nogil
        void (*material)(void *, double *) noexcept nogil
        const double *q
        const double *mass
        const double *inverse_mass
        double mass_total, moved, shift
        int leaps, sudden

    ctypedef struct ancf_frame:
        void *context
        ptrdiff_t n
        void (*hold)(void *, const double *) noexcept nogil
        void (*turn)(void *, const double *) noexcept nogil
        void (*forward)(void *, const double *, double *) noexcept nogil
        void (*backward)(void *, const double *, double *) noexcept nogil

    ctypedef struct ancf_inverse:
        void *context
        ptrdiff_t n
        int (*reseed)(void *) noexcept nogil
        void (*forget)(void *) noexcept nogil
        void (*apply)(void *, const double *, double *) noexcept nogil
        int (*learn)(void *, const double *, const double *, const double *, double *) noexcept nogil

    ctypedef struct ancf_nonlinear:
        void *context
        int (*solve)(void *) noexcept nogil
        int (*confirm)(void *) noexcept nogil
        void (*prefer)(void *) noexcept nogil
        int (*again)(void *, int) noexcept nogil
        const int *doubtful
        const int *saddle
        int (*repeat)(void *) noexcept nogil
