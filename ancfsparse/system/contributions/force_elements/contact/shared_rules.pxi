"""Rules that contacts with obstacles and of beams with each other share; an include file."""
from libc.math cimport sqrt

cdef extern from "parallel.h":
    const int MOST_PARTS "ANCF_MOST_PARTS"
    void in_parts "ancf_in_parts" (
        ptrdiff_t, void (*)(void *, ptrdiff_t) noexcept nogil, void *) noexcept nogil

# Steps per impact below which it is damped fully.  Level impacts on 1e5 N/m2 with 16 steps of
# GeneralizedAlpha(.9) return at most .9975 of their energy; 1.0023 with 1.5 in place of 2.
cdef double STEPS_PER_IMPACT = 2.0
cdef enum:
    N_LOSSES = 3  # energies since the start of a run: work of turning, losses by friction and by damping
# Relative distance of a deflection to its limit below which a bristle of a saved state slides: the
# damped pressure, which limited it, differs from the pressure in the state by up to 1e-4.
cdef double SLIDING_RATIO = 1e-3
# Square of the sine of an angle below which a rotation changes no length by more than rounding error.
cdef double LEVEL = 1e-16


cdef inline double dot(const double *a, const double *b) noexcept nogil:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


cdef inline double damped_share(double restitution) noexcept nogil:
    """Share gamma of the pressure that changes its sign in an impact, 0 without a restitution."""
    return (1.0 - restitution**2) / (1.0 + restitution**2) if restitution > 0.0 else 0.0


cdef inline double remove_normal(const double *n, double *u) noexcept nogil:
    """Project a vector on the tangent plane; return its component along n."""
    cdef double normal = dot(n, u)
    u[0] -= normal * n[0]
    u[1] -= normal * n[1]
    u[2] -= normal * n[2]
    return normal


cdef inline void scale(double factor, double *u) noexcept nogil:
    u[0] *= factor
    u[1] *= factor
    u[2] *= factor


cdef inline void transport(const double *n, double *u) noexcept nogil:
    """Rotate a vector of another tangent plane into that with the normal n."""
    cdef double before = dot(u, u), normal = remove_normal(n, u), after
    if normal * normal > LEVEL * before:
        after = dot(u, u)
        if after > 0.0:
            scale(sqrt(before / after), u)


cdef inline void shorten(double limit, double *u) noexcept nogil:
    """Scale a vector to a limit, if it is longer."""
    cdef double square = dot(u, u)
    if square > limit * limit:
        scale(limit / sqrt(square), u)


cdef inline bint stretch_by(const double *x, double share, double delay, double limit, bint slides,
                            double square, double *u) noexcept nogil:
    """Move the deflection u of a bristle to the end of a step; return whether it slides from then on.

    Its displacement x acts with the given share in friction, `delay` of it by the damper, and the square of the
    deflection is that before it was shortened.
    """
    cdef double[3] trial
    cdef double reached
    cdef int c
    for c in range(3):
        trial[c] = u[c] + share * x[c]
    reached = dot(trial, trial)
    if reached > limit * limit:
        shorten(limit, trial)
        for c in range(3):
            u[c] = (delay * u[c] + trial[c]) / (1.0 + delay)
    else:
        for c in range(3):
            u[c] += x[c]
        shorten(limit, u)
    return reached > (square if slides else limit * limit)
