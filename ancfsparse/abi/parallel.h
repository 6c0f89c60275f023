/* Work in numbered parts, each on its own thread.
 *
 * The assignment of work to parts depends only on their number, never on the machine or on scheduling,
 * so runs are reproducible bit for bit.  A single part is a plain call.
 */
#ifndef ANCF_PARALLEL_H
#define ANCF_PARALLEL_H

#include <Python.h>
#include <stddef.h>

#define ANCF_MOST_PARTS 256

typedef void (*ancf_part)(void *context, ptrdiff_t part);
typedef void (*ancf_run)(ptrdiff_t n_parts, ancf_part work, void *context);

static void ancf_in_turn(ptrdiff_t n_parts, ancf_part work, void *context)
{
    for (ptrdiff_t part = 0; part < n_parts; ++part)
        work(context, part);
}

/* Return the function that does parts, from the module `threads`, whose threads all modules share. */
static ancf_run ancf_find_threads(void)
{
    const PyGILState_STATE state = PyGILState_Ensure();
    PyObject *module = PyImport_ImportModule("ancfsparse.compiled.threads");
    PyObject *capsule = module ? PyObject_GetAttrString(module, "run") : NULL;
    ancf_run run = capsule ? (ancf_run)PyCapsule_GetPointer(capsule, "ancfsparse.compiled.threads.run")
                           : NULL;
    Py_XDECREF(capsule);
    Py_XDECREF(module);
    if (!run) {
        PyErr_Clear();
        run = ancf_in_turn;
    }
    PyGILState_Release(state);
    return run;
}

static inline void ancf_in_parts(ptrdiff_t n_parts, ancf_part work, void *context)
{
    static _Atomic(ancf_run) threads;
    if (n_parts == 1) {
        work(context, 0);
        return;
    }
    ancf_run run = threads;
    if (!run)
        threads = run = ancf_find_threads();
    run(n_parts, work, context);
}

#endif
