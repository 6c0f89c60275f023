/* How the compiled parts of a system hand their work to its assembly, in PyCapsules as in solver_abi.h. */
#ifndef ANCF_SYSTEM_ABI_H
#define ANCF_SYSTEM_ABI_H

#include <stddef.h>

/* The kernels of an element, in the order of KERNELS in system/_elements.pyx. */
enum ancf_quantity {
    ANCF_ENERGY, ANCF_FORCE, ANCF_INERTIA, ANCF_RESIDUAL, ANCF_TANGENT, ANCF_MASS, ANCF_DAMPING,
    ANCF_MATERIAL, ANCF_DISCRETE_GRADIENT, ANCF_N_KERNELS
};

typedef struct {
    void *context;
    ptrdiff_t n_parts; /* threads that share the work */
    int damped;        /* whether any element is */
    /* Add what all elements give, a vector [n_all] or values of the matrix with a bin behind them;
     * with the parameters of damping in place of those of the elements if damped. */
    void (*add)(void *context, int quantity, const double *q, const double *a, double *out,
                int damped);
    double (*strain_energy)(void *context, const double *q);
} ancf_elements;

typedef struct {
    void *context;
    ptrdiff_t n;
    void (*add)(void *context, const double *q, const double *amplitudes, double *r);
    void (*add_stiffness)(void *context, const double *q, const double *amplitudes, double *values);
} ancf_moments;

#endif
