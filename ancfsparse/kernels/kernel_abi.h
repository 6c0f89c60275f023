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
 * Kernels of one element, and what they add:
 *
 *   energy    strain energy, one number per element
 *   force     elastic force Q(q), n numbers
 *   inertia   M a, n numbers
 *   residual  Q(q) + M a, n numbers
 *   tangent   dQ/dq, lower triangle by rows: entry (i, j <= i) is number i (i+1)/2 + j
 *   mass      M, lower triangle by rows
 *   damping   sum over strains of weight * d strain/dt * d strain/dq, n numbers; a holds velocities
 *   material  sum over strains of weight * (d strain/dq)(d strain/dq)^T, lower triangle by rows: the
 *             tangent without stresses, and the derivative of damping by the velocities
 *   discrete_gradient   force between two states, n numbers; q holds the coordinates of the first and a
 *             those of the second: times their difference it is the difference of the energies
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
