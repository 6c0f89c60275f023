/* Copy the entries of a matrix to the storage of its factor. */
#ifndef ANCF_LDL_SPREAD_H
#define ANCF_LDL_SPREAD_H

#include <string.h>

#include "ldl.h"

/* Location of the last entry: the next one is probably in the same supernode, and close. */
typedef struct {
    ptrdiff_t first, end, width, n_rows, in_triangle, in_block, image;
    const int32_t *rows;
    ptrdiff_t at;
} ldl_finger;

LDL_INLINE void ldl_point(const ldl *self, ptrdiff_t column, ldl_finger *finger)
{
    ptrdiff_t s = self->super_of[column];
    finger->first = self->first[s];
    finger->end = self->first[s + 1];
    finger->width = finger->end - finger->first;
    finger->n_rows = ldl_rows(self, s);
    finger->in_triangle = self->triangle - self->entries + self->triangle_start[s];
    finger->in_block = self->block - self->entries + self->block_start[s];
    finger->image = s < self->part[self->n_parts] && self->n_root ? ldl_image_shift(self, s) : 0;
    finger->rows = self->row + self->row_start[s];
    finger->at = 0;
}

/* Index of the entry in a row and column, both given in order of elimination. */
LDL_INLINE ptrdiff_t ldl_locate(const ldl *self, ptrdiff_t row, ptrdiff_t column, ldl_finger *finger)
{
    if (row == column)
        return row;
    if (row < column) {
        ptrdiff_t swap = row;
        row = column;
        column = swap;
    }
    if (column < finger->first || column >= finger->end)
        ldl_point(self, column, finger);
    column -= finger->first;
    if (row < finger->end) {
        row -= finger->first;
        return finger->in_triangle + row * (row - 1) / 2 + column;
    }
    if (row >= self->root_column)
        row += finger->image;
    const int32_t *rows = finger->rows;
    ptrdiff_t at = finger->at, high = finger->n_rows;
    if (at < high && rows[at] == row)
        ; /* the next row of the same column */
    else if (at > 0 && rows[at - 1] == row)
        --at; /* the next column of the same row */
    else {
        at = 0; /* the first row of the next column, or elsewhere */
        while (high - at > 1 && rows[at] != row) {
            ptrdiff_t middle = (at + high) / 2;
            if (rows[middle] <= row)
                at = middle;
            else
                high = middle;
        }
    }
    finger->at = at + 1;
    return finger->in_block + at * finger->width + column;
}

/* Clear the storage of a part; the last part also clears that of the root. */
static void ldl_clear(void *context, ptrdiff_t part)
{
    const ldl *self = context;
    ptrdiff_t a = self->part[part];
    ptrdiff_t b = part + 1 == self->n_parts ? self->n_super : self->part[part + 1];
    int64_t at = self->triangle_start[a];
    memset(self->triangle + at, 0, (self->triangle_start[b] - at) * sizeof(double));
    at = self->block_start[a];
    memset(self->block + at, 0, (self->block_start[b] - at) * sizeof(double));
}

/* Copy the entries of a range of matrix columns. */
static void ldl_spread(void *context, ptrdiff_t part)
{
    const ldl *self = context;
    const double *values = self->values;
    double *entries = self->entries;
    ptrdiff_t begin = self->n * part / self->n_parts, end = self->n * (part + 1) / self->n_parts;
    if (self->place_of_entry) {
        for (int64_t p = self->start[begin]; p < self->start[end]; ++p)
            entries[self->place_of_entry[p]] = values[p];
        return;
    }
    ldl_finger finger = {0};
    for (ptrdiff_t j = begin; j < end; ++j)
        for (int64_t p = self->start[j]; p < self->start[j + 1]; ++p)
            entries[ldl_locate(self, self->place[self->index[p]], self->place[j], &finger)] = values[p];
}

/* Index of every entry of the matrix. */
static void ldl_places(const ldl *self, int32_t *place)
{
    ldl_finger finger = {0};
    for (ptrdiff_t j = 0; j < self->n; ++j)
        for (int64_t p = self->start[j]; p < self->start[j + 1]; ++p)
            place[p] = (int32_t)ldl_locate(self, self->place[self->index[p]], self->place[j], &finger);
}

#endif
