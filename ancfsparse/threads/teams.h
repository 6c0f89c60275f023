/* Teams of threads that wait for work.  A call takes a team that no other call uses, so that runs in
 * several threads of Python do not wait for each other; a team that is missing is made, and kept.
 *
 * Threads and locks are those of CPython, which has them on every system and needs no lock of the
 * interpreter for them.  A team never ends: its threads sleep, and end with the process.
 */
#ifndef ANCF_TEAMS_H
#define ANCF_TEAMS_H

#include <Python.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "parallel.h"

/* Looks at a gate before a thread sleeps, some ten microseconds.  Waking a thread takes longer than most
 * parts; but one that looks for milliseconds takes the processor from others: on a busy machine two
 * threads were ten times slower than one. */
enum { GATE_LOOKS = 1000 };

/* Each time that a gate is opened, one thread passes. */
typedef struct {
    atomic_int state;
    PyThread_type_lock sleep; /* held, but for the moment that wakes a thread */
} gate;
enum { GATE_CLOSED, GATE_OPEN, GATE_SLEEPER };

static int gate_make(gate *self)
{
    atomic_init(&self->state, GATE_CLOSED);
    self->sleep = PyThread_allocate_lock();
    return self->sleep && PyThread_acquire_lock(self->sleep, NOWAIT_LOCK);
}

static void gate_open(gate *self)
{
    if (atomic_exchange(&self->state, GATE_OPEN) == GATE_SLEEPER)
        PyThread_release_lock(self->sleep);
}

static void gate_pass(gate *self)
{
    for (int looks = 0; looks < GATE_LOOKS && atomic_load(&self->state) != GATE_OPEN; ++looks) {
#if defined(__x86_64__)
        __builtin_ia32_pause();
#elif defined(__aarch64__)
        __asm__ volatile("yield");
#endif
    }
    int closed = GATE_CLOSED;
    if (atomic_compare_exchange_strong(&self->state, &closed, GATE_SLEEPER))
        PyThread_acquire_lock(self->sleep, WAIT_LOCK);
    atomic_store(&self->state, GATE_CLOSED);
}

typedef struct team team;

typedef struct {
    team *team;
    ptrdiff_t number;
    gate start;
} team_worker;

struct team {
    team *next; /* in the list of idle teams */
    ptrdiff_t n_workers;
    team_worker *worker[ANCF_MOST_PARTS];
    /* of the call */
    ancf_part work;
    void *context;
    ptrdiff_t n_parts, n_threads;
    atomic_int working; /* workers that have not finished */
    gate finish;
};

static struct {
    PyThread_type_lock lock;
    team *first;
} idle_teams;

static int teams_prepare(void)
{
    idle_teams.lock = PyThread_allocate_lock();
    return idle_teams.lock != NULL;
}

static void team_share(team *self, ptrdiff_t number)
{
    for (ptrdiff_t part = number; part < self->n_parts; part += self->n_threads)
        self->work(self->context, part);
}

static void team_serve(void *worker)
{
    team_worker *self = worker;
    for (;;) {
        gate_pass(&self->start);
        team_share(self->team, self->number);
        if (atomic_fetch_sub(&self->team->working, 1) == 1)
            gate_open(&self->team->finish);
    }
}

#define NO_THREAD ((unsigned long)-1) /* PYTHREAD_INVALID_THREAD_ID, which the limited API leaves out */

/* Start threads until there are n of them, or no more can be had. */
static void team_grow(team *self, ptrdiff_t n)
{
    while (self->n_workers < n) {
        team_worker *worker = malloc(sizeof *worker);
        if (!worker)
            return;
        worker->team = self;
        worker->number = self->n_workers + 1;
        if (!gate_make(&worker->start)
            || PyThread_start_new_thread(team_serve, worker) == NO_THREAD) {
            free(worker);
            return;
        }
        self->worker[self->n_workers++] = worker;
    }
}

static team *team_take(void)
{
    PyThread_acquire_lock(idle_teams.lock, WAIT_LOCK);
    team *self = idle_teams.first;
    if (self)
        idle_teams.first = self->next;
    PyThread_release_lock(idle_teams.lock);
    if (!self) {
        self = calloc(1, sizeof *self);
        if (self && !gate_make(&self->finish)) {
            free(self);
            self = NULL;
        }
    }
    return self;
}

static void team_return(team *self)
{
    PyThread_acquire_lock(idle_teams.lock, WAIT_LOCK);
    self->next = idle_teams.first;
    idle_teams.first = self;
    PyThread_release_lock(idle_teams.lock);
}

/* Do the parts, each on its own thread unless threads are refused.  This is an `ancf_run`. */
static void team_run(ptrdiff_t n_parts, ancf_part work, void *context)
{
    team *self = team_take();
    if (!self) {
        ancf_in_turn(n_parts, work, context);
        return;
    }
    team_grow(self, n_parts - 1);
    const ptrdiff_t n_workers = self->n_workers < n_parts ? self->n_workers : n_parts - 1;
    self->work = work;
    self->context = context;
    self->n_parts = n_parts;
    self->n_threads = 1 + n_workers;
    atomic_store(&self->working, (int)n_workers);
    for (ptrdiff_t i = 0; i < n_workers; ++i)
        gate_open(&self->worker[i]->start);
    team_share(self, 0);
    if (n_workers)
        gate_pass(&self->finish);
    team_return(self);
}

#endif
