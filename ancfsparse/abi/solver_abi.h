/* How the compiled parts of the solver call each other.
 *
 *   time loop ──▶ nonlinear loop ──▶ equations (of one step, owned by the time loop) ──▶ system
 *                      └──▶ inverse (quasi-Newton, perhaps co-rotated by a frame) ──▶ seed (sparse factor)
 *
 * Each part hands out one of these structures in a PyCapsule whose name is the structure's name.
 * The unknowns are x = (free coordinates, multipliers); matrices are the lower triangle of
 *
 *   [ mass_factor M + damping_factor C + stiffness_factor d(Q - f + phi_q^T lam)/dq    phi_q^T ]
 *   [ phi_q                                                                          -epsilon ]
 *
 * as one array of values on a pattern that is fixed before the first step.
 */
#ifndef ANCF_SOLVER_ABI_H
#define ANCF_SOLVER_ABI_H

#include <stddef.h>

/* A state of a system, as far as a question needs it: other pointers are null. */
typedef struct {
    const double *q, *v, *a; /* [n_all] */
    const double *lam, *amplitudes;
} ancf_state;

typedef struct {
    void *context;
    ptrdiff_t n_free, n_all, n_multipliers, n_values, n_amplitudes;
    int damped; /* whether forces depend on v; where not, v may be NULL */
    /* r[n_all] = M a + Q(q, v) - f(amplitudes) + phi_q^T lam,  phi[n_multipliers] = phi(q);
     * without M a where a is null */
    void (*residual)(void *context, const double *q, const double *v, const double *a,
                     const double *lam, const double *dead_load, const double *amplitudes,
                     double *r, double *phi);
    void (*matrix)(void *context, double mass_factor, double stiffness_factor,
                   double damping_factor, const double *q, const double *v, const double *lam,
                   const double *amplitudes, double *values);
    /* The same without what can make it indefinite: only the part of the stiffness that the stress
     * leaves out, J^T D J, and no curvature of constraints or loads.  May be NULL. */
    void (*material)(void *context, double mass_factor, double stiffness_factor,
                     double damping_factor, const double *q, double *values);
    void (*inertia)(void *context, const double *a, double *out); /* out[n_all] = M a */
    /* out = kinetic and strain energy; scratch[n_all] is overwritten */
    void (*energies)(void *context, const double *q, const double *v, double *scratch, double *out);
    /* Work of the changing loads between two states, by the trapezoidal rule; v may be null where
     * forces do not depend on it. */
    double (*load_work)(void *context, const ancf_state *x0, const ancf_state *x1,
                        double *scratch);
    /* Most work that forces of these amplitudes, not negative, could do between two states,
     * whatever their signs: the sum of |force| |motion| over the coordinates. */
    double (*load_reach)(void *context, const double *q0, const double *q1,
                         const double *amplitudes, double *scratch);
    /* The residual between two states with the middle q and the mean velocity v: the elastic force
     * is the discrete gradient DU(q0, q1), everything else is taken at (q, v), phi at q1.  May be
     * NULL, and then nothing that keeps energy can be made of the system. */
    void (*residual_between)(void *context, const double *q0, const double *q1, const double *q,
                             const double *v, const double *a, const double *lam,
                             const double *dead_load, const double *amplitudes, double *r,
                             double *phi);
    /* The state that a run begins with, and each one that it accepts: what the system keeps from
     * step to step changes here and nowhere else.  Null if it keeps nothing.  `a` may be null. */
    void (*begin)(void *context, const ancf_state *x);
    void (*accept)(void *context, const ancf_state *x);
} ancf_system;

typedef struct {
    void *context;
    ptrdiff_t n;
    /* 0 if every pivot has the sign it must have, else 1 + index of the first bad unknown */
    ptrdiff_t (*factor)(void *context, const double *values);
    void (*solve)(void *context, const double *r, double *x); /* x may be r */
    /* Keep the factor in single precision until the next one, for solves that read half as much;
     * NULL where that is not faster */
    void (*round_to_single)(void *context);
    /* Of a seed that inverts a neighbour of the matrix, all NULL in one that inverts the matrix.
     * After `factor` has found a wrong sign there is no factor: */
    int (*mend)(void *context, const double *values); /* factor with a larger diagonal; 0 if it cannot */
    /* Leave no more than a share of r in solves until the next factor; 0 if they leave no more now */
    int (*refine)(void *context, double share);
    const double *extra; /* operations of all solves so far beyond those of the plainest */
} ancf_seed;

typedef struct {
    void *context;
    ptrdiff_t n, n_coordinates, n_values; /* unknowns; coordinates among them come first */
    void (*restart)(void *context); /* x back to the predictor */
    void (*coast)(void *context);   /* x to another start, without the last acceleration; may be NULL */
    /* x += factor s; the sum over the coordinates of mass (factor s)^2 */
    double (*correct)(void *context, double factor, const double *s);
    void (*residual)(void *context, double *r);    /* scaled residual at x */
    void (*matrix)(void *context, double *values); /* scaled iteration matrix at x */
    /* A positive definite neighbour of it, for seeds where it is indefinite; NULL if there is none */
    void (*material)(void *context, double *values);
    const double *q; /* all coordinates at x, fixed ones last; NULL if nothing turns with them */
    /* Lengths of vectors: sqrt(sum mass x^2 / mass_total) of coordinates and, of a residual by what
     * mass alone would make of it, sqrt(sum r^2 / mass / mass_total).  NULL for a mass of one. */
    const double *mass;
    double mass_total;
    double moved; /* length of the way from the last state: to the predictor, or to x where the
                   * scheme keeps it up to date */
    int leaps;    /* whether the predictor is not the sure one, which 0 makes the next restart take */
} ancf_equations;

typedef struct {
    void *context;
    ptrdiff_t n;
    void (*hold)(void *context, const double *q); /* q is the state the seed is for: R = 1 */
    void (*turn)(void *context, const double *q); /* R leads from that state to q */
    void (*forward)(void *context, const double *x, double *y);  /* y = R x; y may be x */
    void (*backward)(void *context, const double *x, double *y); /* y = R^T x; y may be x */
} ancf_frame;

typedef struct {
    void *context;
    ptrdiff_t n;
    int (*reseed)(void *context);  /* the seed has a new factor: forget all pairs */
    void (*forget)(void *context); /* forget all pairs, keep the seed */
    void (*apply)(void *context, const double *r, double *z); /* z = H r */
    /* Learn from the pair (s, y): on entry z = H r_old with s = -z; on exit z = H_new r_new.
     * Returns 1 if the pair was taken, 0 if it was skipped. */
    int (*learn)(void *context, const double *s, const double *y, const double *r_new, double *z);
} ancf_inverse;

typedef struct {
    void *context;
    int (*solve)(void *context); /* one step; a code of outcome.h */
    /* The energy of the solution found is odd: 0 if there is that of Newton to compare it with,
     * which counts as what saved the step only if it is preferred. */
    int (*confirm)(void *context);
    void (*prefer)(void *context);
    /* The solution found is refused, for a reason: 0 if there is another one, else the reason or
     * that of the last attempt. */
    int (*again)(void *context, int reason);
    /* Whether the solution was sought because another one was refused, or from another start: it
     * may be one of several. */
    const int *doubtful;
} ancf_nonlinear;

#endif
