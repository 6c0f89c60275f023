"""Force of a penetration e for unit stiffness, twice differentiable; an include file.

p = e^3/D^2 - e^4/(2 D^3) within a layer of thickness D, and e - D/2 beyond; none for e < 0.
"""
from libc.math cimport fabs

cdef double SAME = 1e-6  # change of a penetration over the layer, below which differences cancel
cdef double GAUSS_POINT = 0.7745966692414834  # sqrt(3/5), the outer ones of three on (-1, 1) [-]


cdef inline double law_force(double e, double layer) noexcept nogil:
    cdef double s
    if e <= 0.0:
        return 0.0
    if e >= layer:
        return e - 0.5 * layer
    s = e / layer
    return layer * s * s * s * (1.0 - 0.5 * s)


cdef inline double law_slope(double e, double layer) noexcept nogil:
    cdef double s
    if e <= 0.0:
        return 0.0
    if e >= layer:
        return 1.0
    s = e / layer
    return s * s * (3.0 - 2.0 * s)


cdef inline double law_energy(double e, double layer) noexcept nogil:
    cdef double s = e / layer
    if e <= 0.0:
        return 0.0
    if s < 1.0:
        return layer * layer * s * s * s * s * (0.25 - 0.1 * s)
    return layer * layer * (0.15 + 0.5 * (s - 1.0) * s)


cdef inline double mean_force(double e0, double e1, double layer) noexcept nogil:
    """Mean of the force over penetrations from e0 to e1, without cancellation.

    Three Gauss points are exact in the layer, where the force is of degree 4, one is beyond.
    """
    cdef double low = e0 if e0 < e1 else e1, high = e1 if e0 < e1 else e0, begin, end, middle, half, sum = 0.0
    if high <= low:
        return law_force(low, layer)
    begin, end = low if low > 0.0 else 0.0, high if high < layer else layer
    if begin < end:
        middle, half = 0.5 * (begin + end), 0.5 * (end - begin)
        sum += 2.0 * half / 18.0 * (
            5.0 * law_force(middle - GAUSS_POINT * half, layer)
            + 8.0 * law_force(middle, layer)
            + 5.0 * law_force(middle + GAUSS_POINT * half, layer))
    begin = low if low > layer else layer
    if begin < high:
        sum += (high - begin) * law_force(0.5 * (begin + high), layer)
    return sum / (high - low)


cdef inline double mean_slope(double e0, double e1, double layer) noexcept nogil:
    """Twice the derivative of the mean force by e1, so that it is the slope where both are equal."""
    cdef double change = e1 - e0
    if fabs(change) <= SAME * layer:
        return law_slope(0.5 * (e0 + e1), layer)
    return 2.0 * (law_force(e1, layer) - mean_force(e0, e1, layer)) / change
