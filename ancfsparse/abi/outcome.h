/* Outcomes of an attempt to solve the equations of a step, and the fallback that recovered the step.
 * Compiled code includes them (outcome.pxi); a test compares nonlinear/outcome.py. */
#ifndef ANCF_OUTCOME_H
#define ANCF_OUTCOME_H

enum ancf_outcome {
    ANCF_CONVERGED = 0,
    ANCF_TOO_MANY = 1,   /* iterations */
    ANCF_DIVERGED = 2,
    ANCF_NOT_FINITE = 3, /* the residual */
    ANCF_GAINED_ENERGY = 4, /* detected by the time loop */
    ANCF_INDEFINITE = 5, /* cause of an event: one of 1 to 3, with a factor of the wrong inertia */
    ANCF_WOULD_GAIN = 6, /* every solution found for a step gains energy: it was not accepted */
    ANCF_HAD_GAINED = 7, /* detected at the end of a run, for some earlier step */
    ANCF_PASSES_THROUGH = 8 /* bodies in contact could pass through each other in the step */
};

/* In the order in which they are tried; with incomplete seeds, descent follows a new seed. */
enum ancf_rung {
    ANCF_METHOD = 0,
    ANCF_NEW_SEED = 1,
    ANCF_DAMPED_NEWTON = 2,
    ANCF_NEWTON = 3,
    ANCF_COASTING = 4, /* Newton from the predictor without the last acceleration */
    ANCF_DESCENT = 5, /* minimization of the potential of the step from its predictor */
    ANCF_LONG_NEWTON = 6 /* damped, with more corrections */
};

#endif
