/* The one calling convention of every element kernel, generated or a user's own.
 *
 * A kernel works on blocks of LANES elements that are computed side by side, one per SIMD lane.
 * It gathers its own coordinates and scatters its own result:
 *
 *   gather[b][i][lane]   place in q and in a of coordinate i of the element in that lane
 *   scatter[b][k][lane]  place in out to which number k of that element is added
 *   set_of[b]            which set of parameters block b uses; ~set_of[b] if that is negative, and then
 *                        the block is a chain: the second node of each lane is the first of the next,
 *                        in gather and in a scatter of n numbers
 *   parameters[s][p][lane]   derived parameters (what the module's prepare() returns)
 *   q, a                 coordinates and accelerations of the whole system
 *   out                  is added to, never cleared
 *
 * Which kernels an element has, what they read and what they add is in kernel_list.h, which the
 * generator writes.
 *
 * The last block is filled up by repeating its last element with every parameter except the length
 * set to zero, so the extra lanes add exact zeros to valid places.
 *
 * A kernel travels in a PyCapsule whose name is ANCF_KERNEL_SIGNATURE.
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
