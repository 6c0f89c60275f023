/* How everything that adds to the equations of motion hands its work to the assembly of a system,
 * in PyCapsules named "ancf_contribution", as in solver_abi.h.
 *
 * A function that is null has nothing to add.  None of them clears what it adds to, none allocates
 * memory, and none needs Python, except that a function of the user's may be called.
 */
#ifndef ANCF_SYSTEM_ABI_H
#define ANCF_SYSTEM_ABI_H

#include <stddef.h>

#include "solver_abi.h"

/* Parts of the matrix. */
enum ancf_part {
    ANCF_STIFFNESS, /* derivative of the force by q: its symmetric part, or a symmetric neighbour */
    ANCF_MATERIAL,  /* a positive semidefinite neighbour of it, which depends on q alone */
    ANCF_DAMPING,   /* derivative by v, symmetric likewise */
    ANCF_MASS,      /* constant */
    ANCF_EQUATIONS, /* phi_q: rows below the coordinates */
    /* phi_q^T W phi_q of some equations, added where masses are: with it the matrix is definite
     * although a flat body's mass is not.  Where phi_q dx = -phi is solved beside it, dx does not
     * depend on W, and multipliers do by W phi alone. */
    ANCF_EQUATION_MASS
};

typedef struct {
    void *context;
    int damped;         /* whether its force depends on v; v may be null where none does */
    ptrdiff_t n_memory; /* numbers that it keeps from one accepted step to the next */
    double *memory;
    /* r[n_all] += M a + Q(q, v) - f(amplitudes) + phi_q^T lam, without M a where a is null;
     * its rows of phi are set, not added to. */
    void (*residual)(void *context, const ancf_state *x, double *r, double *phi);
    /* The same between two states, x in the middle of both: an elastic force is a discrete gradient,
     * force . (q1 - q0) = U(q1) - U(q0), and phi is that of q1.  Null: `residual` in the middle. */
    void (*between)(void *context, const double *q0, const double *q1, const ancf_state *x,
                    double *r, double *phi);
    /* Add to the values of the matrix, which have a bin behind them for fixed coordinates. */
    void (*matrix)(void *context, int part, const ancf_state *x, double *values);
    void (*inertia)(void *context, const double *a, double *r);              /* r += M a */
    void (*damping)(void *context, const double *q, const double *v, double *r); /* what v adds */
    double (*energy)(void *context, const double *q);                        /* U(q) */
    /* Work between two states of a force that has neither energy nor damping, by the trapezoidal
     * rule, and the most that it could do between them: see ancf_system.  scratch[n_all] */
    double (*work)(void *context, const ancf_state *x0, const ancf_state *x1, double *scratch);
    double (*reach)(void *context, const double *q0, const double *q1, const double *amplitudes,
                    double *scratch);
    /* The state at the start of a run, and the next one that a run has accepted: the only places
     * where `memory` may change. */
    void (*begin)(void *context, const ancf_state *x);
    void (*accept)(void *context, const ancf_state *x);
} ancf_contribution;

#endif
