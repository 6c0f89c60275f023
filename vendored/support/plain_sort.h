/* A plain heap sort under the name that METIS uses, in place of GKlib's gk_mksort.h, which is under the LGPL. */
#ifndef ANCF_PLAIN_SORT_H
#define ANCF_PLAIN_SORT_H

/* Sort `n` entries of `base`; `less` takes pointers to two of them. */
#define GK_MKQSORT(TYPE, base, n, less)                                                                                \
  do {                                                                                                                 \
    TYPE *const heap = (base);                                                                                         \
    size_t end = (n), top = end / 2;                                                                                   \
    while (end > 1) {                                                                                                  \
      TYPE moved;                                                                                                      \
      if (top > 0) /* first make a heap, the greatest entry of which is at its top */                                  \
        moved = heap[--top];                                                                                           \
      else { /* then put the greatest entry behind those that are left */                                              \
        moved = heap[--end];                                                                                           \
        heap[end] = heap[0];                                                                                           \
      }                                                                                                                \
      size_t hole = top, child;                                                                                        \
      while ((child = 2 * hole + 1) < end) {                                                                           \
        if (child + 1 < end && less((heap + child), (heap + child + 1)))                                               \
          child++;                                                                                                     \
        if (!less((&moved), (heap + child)))                                                                           \
          break;                                                                                                       \
        heap[hole] = heap[child];                                                                                      \
        hole = child;                                                                                                  \
      }                                                                                                                \
      heap[hole] = moved;                                                                                              \
    }                                                                                                                  \
  } while (0)

#endif
