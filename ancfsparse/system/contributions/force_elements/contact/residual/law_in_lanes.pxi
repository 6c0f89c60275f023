"""The law of contact_law.pxi for as many points as a `vec` has lanes; included by `_contacts.pyx`."""


cdef extern from "point_lanes.h":
    ctypedef double vec "lanes"
    ctypedef struct Block "points_block":
        ptrdiff_t like
    const int LANES "ANCF_LANES"
    vec same "vec_set1" (double) noexcept nogil
    vec load "vec_load" (const double *) noexcept nogil
    vec root "vec_sqrt" (vec) noexcept nogil
    vec where_above "points_where" (vec, vec, vec, vec) noexcept nogil
    bint any_positive "points_any_positive" (vec) noexcept nogil
    void load_vectors "points_load" (const double *, vec *) noexcept nogil
    void store "points_store" (double *, vec, ptrdiff_t) noexcept nogil
    void store_vectors "points_store_vectors" (double *, const vec *, ptrdiff_t) noexcept nogil
    vec first_of "points_first" (vec, ptrdiff_t) noexcept nogil
    void set_block "points_take" (Block *, ptrdiff_t, const int32_t *, const double *) noexcept nogil
    void repeat_block "points_repeat" (
        Block *, ptrdiff_t, ptrdiff_t, const int32_t *, const double *) noexcept nogil
    void sum_points "points_sum" (const Block *, const double *, vec *) noexcept nogil
    void subtract_forces "points_subtract" (const Block *, const vec *, double *) noexcept nogil


cdef inline vec above_zero(vec x) noexcept nogil:
    """The larger one of x and zero."""
    return where_above(x, same(0.0), x, same(0.0))


cdef inline vec force_in_layer(vec s) noexcept nogil:
    """Force over the thickness of the layer, at a share of it."""
    return s * s * s * (1.0 - 0.5 * s)


cdef inline vec law_slopes(vec s) noexcept nogil:
    """`law_slope` at shares of the layer."""
    return s * s * (3.0 - 2.0 * s)


cdef inline vec share_of_layer(vec e, vec inverse) noexcept nogil:
    """Penetrations times the inverse of the layer, between 0 and 1."""
    cdef vec s = e * inverse
    return where_above(s, same(1.0), same(1.0), above_zero(s))


cdef inline vec law_forces(vec e, vec s, vec layer) noexcept nogil:
    """`law_force` at penetrations and their shares of the layer."""
    return above_zero(e - layer) + layer * force_in_layer(s)


cdef inline void mean_law(vec e0, vec e1, vec layer, vec *force, vec *slope) noexcept nogil:
    """Set `mean_force` and `mean_slope`."""
    cdef vec inverse = same(1.0) / layer, change = e1 - e0, middle = 0.5 * (e0 + e1), sum, apart
    cdef vec low = where_above(e0, e1, e1, e0), high = where_above(e0, e1, e0, e1)
    cdef vec begin = above_zero(low), end = where_above(high, layer, layer, high)
    cdef vec half = above_zero(0.5 * inverse * (end - begin)), s = share_of_layer(middle, inverse)
    cdef vec beyond = where_above(low, layer, low, layer)
    if not any_positive(layer - low):
        force[0], slope[0] = middle - 0.5 * layer, same(1.0)
        return
    begin = 0.5 * inverse * (begin + end)
    apart = GAUSS_POINT * half
    sum = 0.5 * above_zero(high - beyond) * (high + beyond - layer) + (
        layer * layer * half * (1.0 / 9.0) * (
            5.0 * (force_in_layer(begin - apart) + force_in_layer(begin + apart))
            + 8.0 * force_in_layer(begin)))
    force[0] = where_above(high, low, sum / (high - low), law_forces(middle, s, layer))
    end = law_forces(e1, share_of_layer(e1, inverse), layer)
    slope[0] = where_above(change * change, SAME * SAME * layer * layer,
                           2.0 * (end - force[0]) / change, law_slopes(s))
