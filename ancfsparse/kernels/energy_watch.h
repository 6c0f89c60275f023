/* Does a motion gain energy that nothing has given it?  The time loops look now and then. */
#ifndef ANCF_ENERGY_WATCH_H
#define ANCF_ENERGY_WATCH_H

#include <math.h>

#include "solver_abi.h"
#include "vectors.h"

typedef struct {
    double limit; /* share of the energy that was exchanged so far; infinite for no watch */
    double noise; /* energy that rounding makes */
    double start, strain, potential; /* at the start: all energy, and two parts of it */
    double work;                     /* of the changing loads; the time loop adds to it */
    double exchanged, gain;          /* at the last look */
    double kinetic;                  /* the largest that was seen */
} ancf_watch;

static inline void ancf_watch_start(ancf_watch *watch, const ancf_system *system,
                                    const double *dead_load, const double *q, const double *v,
                                    double *scratch)
{
    double parts[2];
    system->energies(system->context, q, v, scratch, parts);
    watch->strain = parts[1];
    watch->potential = -vec_dot(dead_load, q, system->n_all);
    watch->start = parts[0] + parts[1] + watch->potential;
}

/* Whether the energy is further above what was given than a share of what was exchanged, or, to be
 * strict, of the motion alone: a load that bends something slowly exchanges far more. */
static inline int ancf_watch_gains(ancf_watch *watch, const ancf_system *system,
                                   const double *dead_load, const double *q, const double *v,
                                   double *scratch, int strict)
{
    double parts[2], potential;
    if (isinf(watch->limit))
        return 0;
    system->energies(system->context, q, v, scratch, parts);
    potential = -vec_dot(dead_load, q, system->n_all);
    watch->kinetic = fmax(watch->kinetic, parts[0]);
    watch->exchanged = fmax(
        fmax(fmax(watch->exchanged, parts[0]), fabs(parts[1] - watch->strain)),
        fmax(fabs(potential - watch->potential), fabs(watch->work)));
    watch->gain = parts[0] + parts[1] + potential - watch->start - watch->work;
    /* A NaN ends here too. */
    return !(watch->gain <= watch->limit * (strict ? watch->kinetic : watch->exchanged)
                                + watch->noise);
}

#endif
