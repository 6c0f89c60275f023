/* Does a motion gain energy that nothing has given it?  The time loops look now and then.
 *
 * The work of changing loads is that of the trapezoidal rule.  Where a load jumps or its rate does
 * inside a step, the work that a scheme makes of it differs by a share of |jump| |motion|, in the
 * step and the few after it: that much is allowed.
 */
#ifndef ANCF_ENERGY_WATCH_H
#define ANCF_ENERGY_WATCH_H

#include <math.h>

#include "solver_abi.h"
#include "vectors.h"

/* Steps from one regular look to the next; only these stop a run.  The first steps are looked at, too,
 * but a motion that has just begun has exchanged too little to compare with. */
#define ANCF_WATCH_EVERY 16
/* A gain above this share of what is allowed is followed from step to step, one at the start through
 * all steps of the first look. */
#define ANCF_WATCH_CLOSE 0.3
/* So many times what is allowed is too much to go on with until the next regular look. */
#define ANCF_WATCH_MUCH 10.0
/* What slow motions exchange counts this much beside kinetic energy. */
#define ANCF_WATCH_SLOW 0.01
/* A jump of less than this share of its load is rounding. */
#define ANCF_JUMP_LEAST 1e-6

typedef struct {
    double limit; /* share of the energy that was exchanged so far; infinite for no watch */
    double noise; /* energy that rounding makes */
    double start, strain, potential; /* at the start: all energy, and two parts of it */
    double work;                     /* of the changing loads; the time loop adds to it */
    double unsure;                   /* sum of the squares of what jumps of loads may have done */
    double exchanged, gain;          /* at the last look */
    double beyond;                   /* the gain less what is unsure or noise */
    double kinetic;                  /* the largest that was seen */
    double most;                     /* the largest `beyond` of an accepted state */
    ptrdiff_t steps, due, when;      /* accepted, that of the next look, that of `most` */
} ancf_watch;

/* The jumps of the changing loads, one place for each amplitude. */
typedef struct {
    ptrdiff_t n;
    double *rate, *bend; /* of the last accepted step: rate, and change of the rate times dt */
    double *size;        /* largest magnitude so far */
    double *past, *jump; /* jumps that still matter: before the step under way, and in it */
    int any;
} ancf_jumps;

static inline void ancf_watch_start(ancf_watch *watch, const ancf_system *system,
                                    const double *dead_load, const double *q, const double *v,
                                    double *scratch)
{
    double parts[2];
    system->energies(system->context, q, v, scratch, parts);
    watch->strain = parts[1];
    watch->potential = -vec_dot(dead_load, q, system->n_all);
    watch->start = parts[0] + parts[1] + watch->potential;
    watch->kinetic = watch->exchanged = parts[0];
    watch->due = 1;
}

/* Look at a state: gain, exchanged and kinetic energy. */
static inline void ancf_watch_measure(ancf_watch *watch, const ancf_system *system,
                                      const double *dead_load, const double *q, const double *v,
                                      double *scratch)
{
    double parts[2], potential;
    if (isinf(watch->limit))
        return;
    system->energies(system->context, q, v, scratch, parts);
    potential = -vec_dot(dead_load, q, system->n_all);
    watch->kinetic = fmax(watch->kinetic, parts[0]);
    watch->exchanged = fmax(
        fmax(fmax(watch->exchanged, parts[0]), fabs(parts[1] - watch->strain)),
        fmax(fabs(potential - watch->potential), fabs(watch->work)));
    watch->gain = parts[0] + parts[1] + potential - watch->start - watch->work;
    watch->beyond = watch->gain - sqrt(watch->unsure) - watch->noise;
}

/* Whether the state looked at has gained more than a share of what was exchanged, or, to be
 * strict, of the motion alone: a load that bends something slowly exchanges far more. */
static inline int ancf_watch_gains(const ancf_watch *watch, int strict)
{
    /* A NaN ends here too. */
    return !isinf(watch->limit)
           && !(watch->beyond <= watch->limit * (strict ? watch->kinetic : watch->exchanged));
}

/* Whether the energy has risen by that much since a look before.  A motion that has lost energy can
 * gain for long before it has more than it was given. */
static inline int ancf_watch_rises(const ancf_watch *watch, const ancf_watch *before)
{
    double rise = watch->gain - before->gain - sqrt(watch->unsure) - watch->noise;
    return !isinf(watch->limit) && !(rise <= watch->limit * watch->exchanged);
}

/* Whether a state that would be the next has gained far more than that, once a motion has begun. */
static inline int ancf_watch_gains_much(const ancf_watch *watch)
{
    return watch->steps + 1 >= ANCF_WATCH_EVERY && !isinf(watch->limit)
           && !(watch->beyond <= ANCF_WATCH_MUCH * watch->limit * watch->exchanged);
}

/* The motion of the whole run, which the largest gain of all states is compared with. */
static inline double ancf_watch_motion(const ancf_watch *watch)
{
    return fmax(watch->kinetic, ANCF_WATCH_SLOW * watch->exchanged);
}

/* Whether an accepted state had gained more than a share of it. */
static inline int ancf_watch_gained(const ancf_watch *watch)
{
    return !isinf(watch->limit)
           && (isnan(watch->beyond) || watch->most > watch->limit * ancf_watch_motion(watch));
}

/* Remember what was seen of the state just accepted, and when to look next. */
static inline void ancf_watch_remember(ancf_watch *watch)
{
    double level;
    if (watch->beyond > watch->most) {
        watch->most = watch->beyond;
        watch->when = watch->steps;
    }
    level = watch->steps < ANCF_WATCH_EVERY ? watch->most : watch->beyond;
    if (level > ANCF_WATCH_CLOSE * watch->limit * watch->kinetic)
        watch->due = watch->steps + 1;
    else if (watch->steps < ANCF_WATCH_EVERY)
        watch->due = 2 * watch->steps;
    else
        watch->due = (watch->steps / ANCF_WATCH_EVERY + 1) * ANCF_WATCH_EVERY;
}

/* Find the jumps of the loads in the step under way: rates that change far more than in the step
 * before, as those of a smooth load do not.  A jump fades by half from step to step. */
static inline void ancf_jumps_find(ancf_jumps *self, const double *load0, const double *load1,
                                   double dt)
{
    ptrdiff_t i;
    self->any = 0;
    for (i = 0; i < self->n; i++) {
        double bend = load1[i] - load0[i] - dt * self->rate[i];
        double jump = fmax(fabs(bend) - 2.0 * fabs(self->bend[i]), 0.5 * self->past[i]);
        double size = fmax(self->size[i], fabs(load1[i]));
        self->jump[i] = jump > ANCF_JUMP_LEAST * size ? jump : 0.0;
        self->any |= self->jump[i] > 0.0;
    }
}

/* Take the loads of the step under way for accepted. */
static inline void ancf_jumps_accept(ancf_jumps *self, const double *load0, const double *load1,
                                     double dt)
{
    ptrdiff_t i;
    for (i = 0; i < self->n; i++) {
        self->bend[i] = load1[i] - load0[i] - dt * self->rate[i];
        self->rate[i] = (load1[i] - load0[i]) / dt;
        self->size[i] = fmax(self->size[i], fabs(load1[i]));
        self->past[i] = self->jump[i];
    }
}

#endif
