/* How an attempt to solve the equations of a step ends, and what saved the step.  The one list of
 * both: compiled code includes it (outcome.pxi), nonlinear/outcome.py reads it. */
#ifndef ANCF_OUTCOME_H
#define ANCF_OUTCOME_H

enum ancf_outcome {
    ANCF_CONVERGED = 0,
    ANCF_TOO_MANY = 1,   /* iterations */
    ANCF_DIVERGED = 2,
    ANCF_NOT_FINITE = 3, /* the residual */
    /* Found by the time loop; the next two end a stretch of steps of one length, not a run. */
    ANCF_GAINED_ENERGY = 4,
    ANCF_TOO_INACCURATE = 5,
    ANCF_MAY_GROW = 6,   /* the step */
    ANCF_INDEFINITE = 7, /* the cause of an event: one of 1 to 3, on a factor with a wrong sign */
    ANCF_WOULD_GAIN = 8, /* every solution found of a step gains energy: it was not accepted */
    ANCF_HAD_GAINED = 9  /* found at the end of a run, of some step before */
};

/* In the order in which they are tried; on incomplete seeds descent comes after a new seed. */
enum ancf_rung {
    ANCF_METHOD = 0,
    ANCF_NEW_SEED = 1,
    ANCF_DAMPED_NEWTON = 2,
    ANCF_NEWTON = 3,
    ANCF_COASTING = 4, /* Newton from the predictor without the last acceleration */
    ANCF_DESCENT = 5 /* down the potential of the step from its predictor */
};

#endif
