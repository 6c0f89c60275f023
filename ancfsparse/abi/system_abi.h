/* The interface between a system's assembly and everything that contributes to the equations of
 * motion: PyCapsules named "ancf_contribution", as in solver_abi.h.
 *
 * A null function contributes nothing.  None of them clears its output before adding to it, none
 * allocates memory except for lists that grow, and none needs Python, except for calls of user functions.
 */
#ifndef ANCF_SYSTEM_ABI_H
#define ANCF_SYSTEM_ABI_H

#include <stddef.h>

#include "solver_abi.h"

/* Parts of the matrix. */
enum ancf_part {
    ANCF_STIFFNESS, /* derivative of the force by q: its symmetric part or a symmetric approximation */
    ANCF_MATERIAL,  /* a positive semidefinite approximation of it that depends on q alone */
    ANCF_DAMPING,   /* derivative by v, likewise symmetric */
    ANCF_MASS,      /* constant */
    ANCF_EQUATIONS, /* phi_q: rows below the coordinates */
    /* phi_q^T W phi_q of some equations, added to the mass matrix: it makes the matrix definite
     * although the mass matrix of a flat body is singular.  Where phi_q dx = -phi is solved as well,
     * dx does not depend on W, and the multipliers change by W phi only. */
    ANCF_EQUATION_MASS
};

typedef struct {
    void *context;
    int damped;         /* whether its force depends on v; v may be null where none does */
    ptrdiff_t n_memory; /* number of history variables, kept from one accepted step to the next */
    double *memory;
    ptrdiff_t n_history; /* number of those that are saved with the states, the first ones */
    /* r[n_all] += M a + Q(q, v) - f(amplitudes) + phi_q^T lam, without M a where a is null;
     * its rows of phi are set, not added to. */
    void (*residual)(void *context, const ancf_state *x, double *r, double *phi);
    /* The same between two states with midpoint x: an elastic force is a discrete gradient,
     * force . (q1 - q0) = U(q1) - U(q0), and phi is that of q1.  Null: `residual` at the midpoint. */
    void (*between)(void *context, const double *q0, const double *q1, const ancf_state *x,
                    double *r, double *phi);
    /* Add to the values of the matrix; an extra entry at the end takes those of fixed coordinates. */
    void (*matrix)(void *context, int part, const ancf_state *x, double *values);
    void (*inertia)(void *context, const double *a, double *r);              /* r += M a */
    /* r += damping force; called where `damped` */
    void (*damping)(void *context, const double *q, const double *v, double *r);
    double (*energy)(void *context, const double *q);                        /* U(q) */
    /* Work between two states of a force that has neither a potential nor damping, by the trapezoidal
     * rule, and an upper bound of it: see ancf_system.  scratch[n_all] */
    double (*work)(void *context, const ancf_state *x0, const ancf_state *x1, double *scratch);
    double (*reach)(void *context, const double *q0, const double *q1, const double *amplitudes,
                    double *scratch);
    /* Called with the initial state of a run, and with each accepted state: the only places where
     * `memory` may change. */
    void (*begin)(void *context, const ancf_state *x);
    void (*accept)(void *context, const ancf_state *x);
    /* As in ancf_system */
    void (*set_step)(void *context, double dt);
    /* Of its equations: speed[n_multipliers] += phi_q v, and bend[n_multipliers] += (phi_q v)_q v
     * unless `bend` is null */
    void (*rates)(void *context, const double *q, const double *v, double *speed, double *bend);
    /* Set what its energy depends on besides q, such as the length of a rope that is wound up: called
     * before its other functions with amplitudes that may have changed.  Null: q alone. */
    void (*tune)(void *context, const double *amplitudes);
    /* Whether a step between two states lets no bodies pass through each other.  Null: any step. */
    int (*admits)(void *context, const double *q0, const double *q1);
    /* As in ancf_system */
    int (*contacts_changed)(void *context);
    void (*add_impulses)(void *context, double weight);
    int (*end_impulses)(void *context, double weight, const ancf_state *x0, const ancf_state *x1,
                        double *gain, double *out);
} ancf_contribution;

#endif
