/* Work in numbered parts, each on its own thread.
 *
 * The assignment of work to parts depends only on their number, never on the machine or on scheduling,
 * so runs are reproducible bit for bit.  A single part is a plain call.
 */
#ifndef ANCF_PARALLEL_H
#define ANCF_PARALLEL_H

#include <stddef.h>

#define ANCF_MOST_PARTS 256

typedef void (*ancf_part)(void *context, ptrdiff_t part);

static inline void ancf_in_parts(ptrdiff_t n_parts, ancf_part work, void *context)
{
    if (n_parts == 1) {
        work(context, 0);
        return;
    }
#pragma omp parallel for num_threads((int)n_parts) schedule(static, 1)
    for (ptrdiff_t part = 0; part < n_parts; ++part)
        work(context, part);
}

#endif
