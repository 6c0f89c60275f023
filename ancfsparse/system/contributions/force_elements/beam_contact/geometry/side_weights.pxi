"""Weights of the points of both axes of two elements; an include file.

Where one axis is bent around the other one, only its own points have unique feet.
"""
# Distance of a point from the centre of curvature of the other axis, over the radius of curvature.  Up
# to the first one its foot does not count, and from the second one on it does, which is reached by axes
# bent to twice the distance of both.  With all feet, 12 of 27 runs of a rope over a bar fail.
cdef double MIN_CURVATURE_DISTANCE = 0.1
cdef double FULL_CURVATURE_DISTANCE = 0.5
cdef double MIN_WEIGHT = 1e-6  # for points on both axes that are at centres of curvature


cdef double certainty(const Cubic *axis, double z, const Foot *foot, double sign) noexcept nogil:
    """Return how well a point at an offset along the normal n has a foot at z of an axis, from 0 to 1.

    A curve that is parallel to the axis, at an offset towards its centre of curvature, is shorter
    than it.  At the centre its length is zero, and the foot is not unique.
    """
    cdef double[3] slope
    cdef double[3] bend
    cdef double square, ratio
    cdef int c
    slope_at(axis, z, slope)
    for c in range(3):
        bend[c] = 2.0 * axis.factor[2][c] + 6.0 * z * axis.factor[3][c]
    square = dot(slope, slope)
    if square == 0.0:
        return 1.0
    ratio = dot(foot.n, bend) - dot(foot.n, slope) * dot(slope, bend) / square
    ratio = 1.0 - sign * foot.distance * ratio / square
    ratio = (ratio - MIN_CURVATURE_DISTANCE) / (FULL_CURVATURE_DISTANCE - MIN_CURVATURE_DISTANCE)
    ratio = fmin(fmax(ratio, 0.0), 1.0)
    return ratio * ratio * (3.0 - 2.0 * ratio)


cdef double side_weight(const Sides *self, double z, const Foot *foot) noexcept nogil:
    """Return the weight of a point of axis a in the sum over both axes, from 0 to 2.

    It is 1, except where an axis is bent around the other one: there the points of the other one lie
    near the centres of curvature, where they have no unique foot, and those of the bent axis count.
    """
    cdef double own = MIN_WEIGHT + certainty(self.b, foot.u, foot, 1.0)
    cdef double other = MIN_WEIGHT + certainty(self.a, z, foot, -1.0)
    return 2.0 * own / (own + other)
