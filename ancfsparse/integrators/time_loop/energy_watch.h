/* Detection of energy gains that no load accounts for.  The time loops check at regular intervals.
 *
 * The work of changing loads is computed by the trapezoidal rule.  Where a load or its rate jumps
 * within a step, the work done by an integration scheme differs from it by a fraction of
 * |jump| |motion|, in that step and the few that follow: a gain of this size is allowed.  An
 * implicit start contains the rate of the loads in its first step, which therefore allows for less.
 *
 * So is a gain by rounding.  With the energy E of a motion as its squared length, the rounding of a step is
 * an error of length e, which later steps do not increase.  After n steps the length is at most
 * sqrt(E) + (n + 1) e, with the rounding of the energy itself.
 */
#ifndef ANCF_ENERGY_WATCH_H
#define ANCF_ENERGY_WATCH_H

#include <math.h>

#include "solver_abi.h"
#include "vectors.h"

/* Steps between two regular checks; only these stop a run.  All steps up to the first one are checked
 * too, but a motion that has just begun has exchanged too little energy to compare with. */
#define ANCF_WATCH_EVERY 16
/* A gain above this fraction of the limit, or below it by no more than the gain has changed from one
 * state seen to the next, is monitored in every step. */
#define ANCF_WATCH_CLOSE 0.3
/* A gain of this many times the limit does not wait for the next regular check. */
#define ANCF_WATCH_MUCH 10.0
/* Nor does a gain of this fraction of the energy exchanged with contact, in the first steps too, as deep
 * penetrations of a first guess can have any energy: a beam bent around a drum flew off with 4.5e7 J, by
 * a step from 100 J, and the run went on to step 16. */
#define ANCF_WATCH_ALL 0.9
/* Steps after which an explicit motion has begun.  The trapezoidal work of a load that begins smoothly
 * is off by more than 1 % of the energy in the first 8 steps of a method of order 8, and in the first
 * 19 of central differences, whose own error adds. */
#define ANCF_WATCH_BEGUN 32
/* Weight of the energy exchanged by slow motions relative to kinetic energy. */
#define ANCF_WATCH_SLOW 0.01
/* A jump smaller than this fraction of its load is rounding error. */
#define ANCF_JUMP_LEAST 1e-6

typedef struct {
    double limit; /* fraction of the energy exchanged so far; infinite: nothing is checked */
    double noise;    /* energy due to rounding, however many steps are taken */
    double rounding; /* root of the energy of the errors by rounding in a step */
    double errors;   /* sum of these roots over all steps so far */
    double start, strain, potential; /* at the start: total energy, and two parts of it */
    double work;                     /* of the changing loads; the time loop adds to it */
    double unsure;                   /* sum of the squares of the uncertain work of load jumps */
    double exchanged, gain;          /* at the last check */
    double beyond;                   /* the gain minus uncertain work and rounding */
    double kinetic;                  /* the largest so far */
    double most;                     /* the largest `beyond` of an accepted state */
    double seen, swing;              /* gain at the last state seen; its largest change from one to
                                      * the next */
    ptrdiff_t steps, due, when;      /* accepted steps, of explicit motions those since energy was
                                      * exchanged; step of the next check; step of `most` */
} ancf_watch;

/* The jumps of the changing loads, one entry per amplitude. */
typedef struct {
    ptrdiff_t n;
    double first;        /* part of the change in a first step that counts as a jump */
    double *rate, *bend; /* in the last accepted step: rate, and change of the rate times dt; NaN
                          * as a rate before the first step, which such a start knows */
    double *size;        /* largest magnitude so far */
    double *past, *jump; /* jumps that still matter: before the current step, and in it */
    int any;
} ancf_jumps;

static inline void ancf_watch_start(ancf_watch *watch, const ancf_system *system,
                                    const double *dead_load, const double *amplitudes,
                                    const double *q, const double *v, double *scratch)
{
    double parts[2];
    system->energies(system->context, q, v, amplitudes, scratch, parts);
    watch->strain = parts[1];
    watch->potential = -vec_dot(dead_load, q, system->n_all);
    watch->start = parts[0] + parts[1] + watch->potential;
    watch->kinetic = watch->exchanged = parts[0];
    watch->errors = watch->rounding;
    watch->due = 1;
}

/* The largest gain that is rounding by errors of some length, beside the energy exchanged so far. */
static inline double ancf_rounding_by(const ancf_watch *watch, double errors)
{
    double energy = fabs(watch->strain) + 2.0 * watch->exchanged; /* not less than strain and kinetic */
    return watch->noise + errors * (errors + 2.0 * sqrt(energy));
}

/* The same by the errors of all steps so far. */
static inline double ancf_watch_rounding(const ancf_watch *watch)
{
    return ancf_rounding_by(watch, watch->errors);
}

/* Evaluate a state: gain, exchanged and kinetic energy. */
static inline void ancf_watch_measure(ancf_watch *watch, const ancf_system *system,
                                      const double *dead_load, const double *amplitudes,
                                      const double *q, const double *v, double *scratch)
{
    double parts[2], potential;
    if (isinf(watch->limit))
        return;
    system->energies(system->context, q, v, amplitudes, scratch, parts);
    potential = -vec_dot(dead_load, q, system->n_all);
    watch->kinetic = fmax(watch->kinetic, parts[0]);
    watch->exchanged = fmax(
        fmax(fmax(watch->exchanged, parts[0]), fabs(parts[1] - watch->strain)),
        fmax(fabs(potential - watch->potential), fabs(watch->work)));
    watch->gain = parts[0] + parts[1] + potential - watch->start - watch->work;
    watch->beyond = watch->gain - sqrt(watch->unsure) - ancf_watch_rounding(watch);
}

/* Whether the evaluated state has gained more than a fraction of the exchanged energy or, if strict,
 * of the energy of the motion alone: a load that deforms a body slowly exchanges far more. */
static inline int ancf_watch_gains(const ancf_watch *watch, int strict)
{
    /* True for NaN as well. */
    return !isinf(watch->limit)
           && !(watch->beyond <= watch->limit * (strict ? watch->kinetic : watch->exchanged));
}

/* Whether the evaluated state of an explicit motion has gained too much: at first, all its energy. */
static inline int ancf_watch_stops(const ancf_watch *watch)
{
    return ancf_watch_gains(watch, 0)
           && (watch->steps >= ANCF_WATCH_BEGUN || !(watch->beyond <= watch->exchanged));
}

/* Whether the energy has risen by that much since an earlier check.  A motion that has lost energy
 * can gain for a long time before it exceeds the energy supplied to it. */
static inline int ancf_watch_rises(const ancf_watch *watch, const ancf_watch *before)
{
    double errors = watch->errors - before->errors + 2.0 * watch->rounding; /* of both energies too */
    double rise = watch->gain - before->gain - sqrt(watch->unsure) - ancf_rounding_by(watch, errors);
    return !isinf(watch->limit) && !(rise <= watch->limit * watch->exchanged);
}

/* Whether a candidate for the next state has gained far more than that; in the first steps, nearly all
 * of the energy exchanged, with contact. */
static inline int ancf_watch_gains_much(const ancf_watch *watch, int has_contact)
{
    int has_begun = watch->steps + 1 >= ANCF_WATCH_EVERY;
    double ratio = has_begun ? ANCF_WATCH_MUCH * watch->limit : ANCF_WATCH_ALL;
    return !isinf(watch->limit) && (has_begun || has_contact)
           && !(watch->beyond <= ratio * watch->exchanged);
}

/* Energy of the motion over the whole run, with which the largest gain of all states is compared. */
static inline double ancf_watch_motion(const ancf_watch *watch)
{
    return fmax(watch->kinetic, ANCF_WATCH_SLOW * watch->exchanged);
}

/* Whether an accepted state had gained more than a fraction of it. */
static inline int ancf_watch_gained(const ancf_watch *watch)
{
    return !isinf(watch->limit)
           && (isnan(watch->beyond) || watch->most > watch->limit * ancf_watch_motion(watch));
}

/* Record the values of the state just accepted, and schedule the next check. */
static inline void ancf_watch_remember(ancf_watch *watch)
{
    if (watch->beyond > watch->most) {
        watch->most = watch->beyond;
        watch->when = watch->steps;
    }
    watch->swing = fmax(watch->swing, fabs(watch->gain - watch->seen));
    watch->seen = watch->gain;
    if (watch->steps < ANCF_WATCH_EVERY
        || watch->beyond + watch->swing > ANCF_WATCH_CLOSE * watch->limit * watch->kinetic)
        watch->due = watch->steps + 1;
    else
        watch->due = (watch->steps / ANCF_WATCH_EVERY + 1) * ANCF_WATCH_EVERY;
}

/* The change of the rate of a load in the current step, times dt. */
static inline double ancf_bend(const ancf_jumps *self, ptrdiff_t i, double change, double dt)
{
    return isnan(self->rate[i]) ? 0.0 : change - dt * self->rate[i];
}

/* Find the jumps of the loads in the current step: rates that change far more than in the previous
 * step, unlike those of a smooth load.  The effect of a jump halves from step to step.  Return
 * whether there is one in this very step. */
static inline int ancf_jumps_find(ancf_jumps *self, const double *load0, const double *load1,
                                   double dt)
{
    ptrdiff_t i;
    int sudden = 0;
    self->any = 0;
    for (i = 0; i < self->n; i++) {
        double change = load1[i] - load0[i], bend = ancf_bend(self, i, change, dt);
        double new = isnan(self->rate[i]) ? self->first * fabs(change)
                                          : fabs(bend) - 2.0 * fabs(self->bend[i]);
        double jump = fmax(new, 0.5 * self->past[i]);
        double size = fmax(self->size[i], fabs(load1[i]));
        self->jump[i] = jump > ANCF_JUMP_LEAST * size ? jump : 0.0;
        self->any |= self->jump[i] > 0.0;
        sudden |= new > 0.5 * self->past[i] && self->jump[i] > 0.0;
    }
    return sudden;
}

/* Accept the loads of the current step. */
static inline void ancf_jumps_accept(ancf_jumps *self, const double *load0, const double *load1,
                                     double dt)
{
    ptrdiff_t i;
    for (i = 0; i < self->n; i++) {
        double change = load1[i] - load0[i];
        self->bend[i] = ancf_bend(self, i, change, dt);
        self->rate[i] = change / dt;
        self->size[i] = fmax(self->size[i], fabs(load1[i]));
        self->past[i] = self->jump[i];
    }
}

#endif
