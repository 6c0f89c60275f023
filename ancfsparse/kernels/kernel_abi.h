/* The calling convention of all element kernels, generated or user-defined.
 *
 * A kernel works on blocks of LANES elements that are computed in parallel, one per SIMD lane.
 * It gathers its coordinates and scatters its result:
 *
 *   gather[b][i][lane]   index in q and in a of coordinate i of the element in that lane
 *   scatter[b][k][lane]  index in out to which component k of that element is added
 *   set_of[b]            parameter set of block b; a negative entry stands for set ~set_of[b], and then
 *                        the block is a chain: the second node of each lane is the first of the next,
 *                        in gather and in a scatter of n components
 *   parameters[s][p][lane]   derived parameters (returned by the module's prepare())
 *   q, a                 coordinates and accelerations of the whole system
 *   out                  is added to, never cleared
 *
 * The kernels of an element, their inputs and results are listed in kernel_list.h, which the
 * generator writes.
 *
 * The last block is padded by repeating its last element with every parameter except the length set
 * to zero, so the extra lanes add exact zeros to valid entries.
 *
 * A kernel is passed in a PyCapsule named ANCF_KERNEL_SIGNATURE.
 */
#ifndef ANCF_KERNEL_ABI_H
#define ANCF_KERNEL_ABI_H

#include <stddef.h>
#include <stdint.h>

#define ANCF_KERNEL_SIGNATURE "ancf_kernel_v1"

typedef void (*ancf_kernel)(ptrdiff_t n_blocks, const int32_t *gather, const int32_t *scatter,
                            const int32_t *set_of, const double *parameters,
                            const double *q, const double *a, double *out);

#endif
