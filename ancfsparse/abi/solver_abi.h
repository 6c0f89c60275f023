/* The interfaces between the compiled parts of the solver.
 *
 *   time loop ──▶ nonlinear loop ──▶ equations (of one step, owned by the time loop) ──▶ system
 *                      └──▶ inverse (quasi-Newton, perhaps co-rotated by a frame) ──▶ seed (sparse factor)
 *
 * Each part exposes one of these structures in a PyCapsule named after the structure.
 * The unknowns are x = (free coordinates, multipliers); matrices are the lower triangle of
 *
 *   [ mass_factor M + damping_factor C + stiffness_factor d(Q - f + phi_q^T lam)/dq    phi_q^T ]
 *   [ phi_q                                                                          -epsilon ]
 *
 * stored as one array of values on a sparsity pattern that is fixed before the first step.
 */
#ifndef ANCF_SOLVER_ABI_H
#define ANCF_SOLVER_ABI_H

#include <stddef.h>
#include <stdint.h>

/* A state of a system; pointers that a function does not need may be null. */
typedef struct {
    const double *q, *v, *a; /* [n_all] */
    const double *lam, *amplitudes;
} ancf_state;

typedef struct {
    void *context;
    ptrdiff_t n_free, n_all, n_multipliers, n_values, n_amplitudes;
    int damped; /* whether forces depend on v; if not, v may be NULL */
    /* r[n_all] = M a + Q(q, v) - f(amplitudes) + phi_q^T lam,  phi[n_multipliers] = phi(q);
     * without M a where a is null */
    void (*residual)(void *context, const double *q, const double *v, const double *a,
                     const double *lam, const double *dead_load, const double *amplitudes,
                     double *r, double *phi);
    void (*matrix)(void *context, double mass_factor, double stiffness_factor,
                   double damping_factor, const double *q, const double *v, const double *lam,
                   const double *amplitudes, double *values);
    /* The same without the terms that can make it indefinite: of the stiffness only the material
     * part J^T D J without the geometric one, and no curvature of constraints or loads.  May be NULL. */
    void (*material)(void *context, double mass_factor, double stiffness_factor,
                     double damping_factor, const double *q, double *values);
    void (*inertia)(void *context, const double *a, double *out); /* out[n_all] = M a */
    /* out = kinetic and strain energy, that with the lengths and strains of these amplitudes, or of
     * the last call where they are null; scratch[n_all] is overwritten */
    void (*energies)(void *context, const double *q, const double *v, const double *amplitudes,
                     double *scratch, double *out);
    /* Work of the changing loads, lengths and strains, and of contact friction, between two states; v may be null if
     * forces do not depend on it.  Null, like the next one, if there are none. */
    double (*load_work)(void *context, const ancf_state *x0, const ancf_state *x1,
                        double *scratch);
    /* Upper bound of the work of forces with these non-negative amplitudes between two states,
     * whatever their signs: the sum of |force| |motion| over the coordinates. */
    double (*load_reach)(void *context, const double *q0, const double *q1,
                         const double *amplitudes, double *scratch);
    /* The residual between two states with midpoint q and mean velocity v: the elastic force is the
     * discrete gradient DU(q0, q1), everything else is evaluated at (q, v), phi at q1.  If NULL, the
     * system has no energy-conserving form. */
    void (*residual_between)(void *context, const double *q0, const double *q1, const double *q,
                             const double *v, const double *a, const double *lam,
                             const double *dead_load, const double *amplitudes, double *r,
                             double *phi);
    /* Called with the initial state of a run, and with each accepted state: the history variables
     * of the system change only here.  Null if it has none.  `a` may be null. */
    void (*begin)(void *context, const ancf_state *x);
    void (*accept)(void *context, const ancf_state *x);
    /* Copy the history variables that are saved with the states */
    ptrdiff_t n_history;
    void (*history)(void *context, double *out);
    /* Set the length of the step that the next residuals and matrices belong to [s], 0 outside of
     * one, negative if it is explicit: then impacts are not damped; null if none depends on it. */
    void (*set_step)(void *context, double dt);
    /* Whether a step between two states lets no bodies pass through each other; null: any step. */
    int (*admits)(void *context, const double *q0, const double *q1);
    /* Whether bodies touch in other places than in the last accepted state, by the last residual;
     * null: never. */
    int (*contacts_changed)(void *context);
    /* Add the pressures of the last residual, times a part of an explicit step, to their impulses in it.
     * Null, like the next one, without contacts. */
    void (*add_impulses)(void *context, double weight);
    /* End such a step; the weight is the part of it that the pressures at its start have.  Add the energy
     * that points which separate have gained since they touched to `gain`, and forces that pull them
     * back to out[n_all]; return whether any point touches in the step. */
    int (*end_impulses)(void *context, double weight, const ancf_state *x0, const ancf_state *x1,
                        double *gain, double *out);
    /* values += factor more, of two matrices without a residual in between */
    void (*add)(void *context, double factor, const double *more, double *values);
} ancf_system;

/* Blocks of a matrix that couple pairs of elements in contact, behind the values on the pattern and the
 * one for fixed coordinates.  The list of pairs changes with the contacts, but not in a matrix; a seed
 * that does not know of it leaves the blocks out. */
typedef struct {
    ptrdiff_t n, size;   /* pairs in the list, and values of the block of each */
    ptrdiff_t first;     /* index of the first value, set by the assembly */
    ptrdiff_t changes;   /* of the list since its start */
    int used;            /* whether the matrix has room for the blocks */
    const int32_t *pair; /* (n, 2): elements, the lower one, of the rows, first */
} ancf_coupling;

typedef struct {
    void *context;
    ptrdiff_t n;
    /* 0 if every pivot has the required sign, else 1 + index of the first unknown where it has not */
    ptrdiff_t (*factor)(void *context, const double *values);
    void (*solve)(void *context, const double *r, double *x); /* x may be r */
    /* Store the factor in single precision until the next factorization, which halves the memory
     * traffic of solves; NULL where that is not faster */
    void (*round_to_single)(void *context);
    /* For approximate (incomplete) seeds; all NULL in an exact one.
     * After `factor` has found a wrong sign there is no factor: */
    int (*mend)(void *context, const double *values); /* factor with a larger diagonal; 0 if impossible */
    /* Reduce the residual of solves to this fraction of r until the next factorization; 0 if it is
     * no larger now */
    int (*refine)(void *context, double share);
    const double *extra; /* operations of all solves so far in excess of single sweeps */
    /* All columns of the inverse, `stride` apart; space[8 n] is overwritten.  NULL where solves for unit
     * vectors are not slower. */
    void (*inverse)(void *context, double *columns, ptrdiff_t stride, double *space);
} ancf_seed;

typedef struct {
    void *context;
    ptrdiff_t n, n_coordinates, n_values; /* unknowns; of these, the coordinates come first */
    void (*restart)(void *context); /* reset x to the predictor */
    void (*coast)(void *context);   /* set x to a predictor without the last acceleration; may be NULL */
    /* x += factor s; returns the sum over the coordinates of mass (factor s)^2 */
    double (*correct)(void *context, double factor, const double *s);
    /* Scaled residual at x; returns the sum over the coordinates of r^2 / mass, if there are masses */
    double (*residual)(void *context, double *r);
    void (*matrix)(void *context, double *values); /* scaled iteration matrix at x */
    /* A positive definite approximation, for seeds where the matrix is indefinite; NULL if none */
    void (*material)(void *context, double *values);
    const double *q; /* all coordinates at x, fixed ones last; NULL if nothing rotates with them */
    /* Weights of the norms: sqrt(sum mass x^2 / mass_total) of coordinates and, for a residual, the
     * displacement if there were inertia alone, sqrt(sum r^2 / mass / mass_total).  NULL: unit mass. */
    const double *mass, *inverse_mass;
    double mass_total;
    double moved; /* norm of the displacement from the last state to the predictor, or to x if the
                   * scheme updates it */
    double shift; /* norm of the displacement from the default predictor to the one in use, 0 if unknown */
    int leaps;    /* whether an alternative predictor is in use; set to 0 to restart from the default */
    int sudden;   /* whether a load jumps in the step, so that earlier ones are no guide to it */
} ancf_equations;

typedef struct {
    void *context;
    ptrdiff_t n;
    void (*hold)(void *context, const double *q); /* the seed is factored at q: R = 1 there */
    void (*turn)(void *context, const double *q); /* R is the rotation from that state to q */
    void (*forward)(void *context, const double *x, double *y);  /* y = R x; y may be x */
    void (*backward)(void *context, const double *x, double *y); /* y = R^T x; y may be x */
} ancf_frame;

typedef struct {
    void *context;
    ptrdiff_t n;
    int (*reseed)(void *context);  /* the seed has a new factor: drop all pairs */
    void (*forget)(void *context); /* drop all pairs, keep the seed */
    void (*apply)(void *context, const double *r, double *z); /* z = H r */
    /* Update with the pair (s, y): on entry z = H r_old with s = -z; on exit z = H_new r_new.
     * Returns 1 if the pair was used, 0 if it was skipped. */
    int (*learn)(void *context, const double *s, const double *y, const double *r_new, double *z);
} ancf_inverse;

typedef struct {
    void *context;
    int (*solve)(void *context); /* one step; a code of outcome.h */
    /* Called when the energy of the solution is suspect: 0 if Newton's method found a solution to
     * compare it with, which counts as a recovery only if it is preferred. */
    int (*confirm)(void *context);
    void (*prefer)(void *context);
    /* Called when the solution is rejected for a reason: 0 if another one is found, else that reason
     * or the one of the last attempt. */
    int (*again)(void *context, int reason);
    /* Whether the solution was computed after another one was rejected, or from another start: it
     * may be one of several. */
    const int *doubtful;
    /* Whether the last matrix on the way to the solution had a pivot of the wrong sign although the
     * equations have a potential: then the solution is a saddle point of it. */
    const int *saddle;
    /* Solve the step again, because its equations have changed; the next step has other ones. */
    int (*repeat)(void *context);
} ancf_nonlinear;

#endif
