"""Force laws of springs: force, mean and integral between two elongations, and tangent stiffness.

Included by `_springs.pyx`.
"""
from libc.math cimport NAN, fabs, isfinite


cdef double DIFFERENCE_STEP = 6e-6  # relative, the cube root of the unit roundoff
cdef double INTEGRAL_TOLERANCE = 1e-14  # relative
cdef int MAX_BISECTIONS = 40
# The positive Gauss points on (-1, 1), and their weights.
cdef double[5] POINT = [0.14887433898163122, 0.4333953941292472, 0.6794095682990244,
                        0.8650633666889845, 0.9739065285171717]
cdef double[5] WEIGHT = [0.29552422471475287, 0.26926671930999635, 0.21908636251598204,
                         0.14945134915058059, 0.06667134430868814]


cdef double call(const Law *law, double elongation) noexcept with gil:
    """Evaluate a force law in Python; after an error no law is called again."""
    cdef Springs owner = <Springs>law.owner
    if owner.raised is not None:
        return NAN
    try:
        return float((<object>law.function)(elongation))
    except BaseException as error:  # a user function may raise anything
        owner.raised, owner.where = error, elongation
        owner.which = law - owner.data.laws
        return NAN


cdef double force(const Data *self, ptrdiff_t k, double elongation) noexcept nogil:
    cdef Law *law = &self.laws[k]
    cdef double found
    if law.plain != NULL:
        found = law.plain(elongation)
    elif law.with_data != NULL:
        found = law.with_data(elongation, law.data)
    elif law.function != NULL:
        found = call(law, elongation)
    else:
        return self.stiffness[k] * elongation
    law.failed, law.elongation = not isfinite(found), elongation
    return found


cdef inline bint is_linear(const Data *self, ptrdiff_t k) noexcept nogil:
    cdef const Law *law = &self.laws[k]
    return law.plain == NULL and law.with_data == NULL and law.function == NULL


cdef double mean(const Data *self, ptrdiff_t k, double begin, double end) noexcept nogil:
    """Mean of a force law between two elongations, by the ten-point Gauss rule."""
    cdef double middle = 0.5 * (begin + end), half = 0.5 * (end - begin), sum = 0.0
    cdef int i
    for i in range(5):
        sum += WEIGHT[i] * (force(self, k, middle - half * POINT[i])
                            + force(self, k, middle + half * POINT[i]))
    return 0.5 * sum


cdef inline double gauss(const Data *self, ptrdiff_t k, double begin, double end) noexcept nogil:
    return (end - begin) * mean(self, k, begin, end)


cdef double refined(const Data *self, ptrdiff_t k, double begin, double end, double whole,
                    double allowed, int halves) noexcept nogil:
    """Integrate adaptively: bisect until the halves add up to the whole, for laws with kinks."""
    cdef double middle = 0.5 * (begin + end)
    cdef double left = gauss(self, k, begin, middle), right = gauss(self, k, middle, end)
    cdef double limit = allowed
    if fabs(left) + fabs(right) > 0.0:
        limit = max(allowed, INTEGRAL_TOLERANCE * (fabs(left) + fabs(right)))
    if halves == 0 or not fabs(left + right - whole) > limit:
        return left + right
    return (refined(self, k, begin, middle, left, allowed, halves - 1)
            + refined(self, k, middle, end, right, allowed, halves - 1))


cdef double integral(const Data *self, ptrdiff_t k, double begin, double end) noexcept nogil:
    """Work of a force law from one elongation to another."""
    cdef double whole = gauss(self, k, begin, end)
    return refined(self, k, begin, end, whole, INTEGRAL_TOLERANCE * fabs(whole), MAX_BISECTIONS)


cdef double slope(const Data *self, ptrdiff_t k, double elongation) noexcept nogil:
    """Derivative of a force by the elongation; an approximation suffices."""
    cdef double step
    if is_linear(self, k):
        return self.stiffness[k]
    step = DIFFERENCE_STEP * self.scale[k]
    return (force(self, k, elongation + step) - force(self, k, elongation - step)) / (2.0 * step)
