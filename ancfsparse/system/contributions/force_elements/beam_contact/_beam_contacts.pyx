# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Contact of the axes of elements with each other.

A point of one axis at the distance |d| from its foot on another one has the penetration
e = reach - |d|, and a pressure k e along d / |d|.  It is integrated where e is positive, by Gauss
points between the ends of each overlap of two elements, on both axes, which halves its stiffness.
The energy k e^2 / 2 is zero at these ends, so they do not contribute to its derivative.

Between two states the force is its mean over the straight path between them, by Simpson's rule, along
the vectors d halfway, and a correction without momentum that makes its work the change of the energy.
"""
include "../../contribution.pxi"
include "axis_overlap.pxi"
include "pair_search.pxi"
include "touching_points.pxi"
include "mean_forces.pxi"
include "separation.pxi"

CROWDED = f"an element has more than {MOST_PER_ELEMENT} others within reach on average"


cdef class BeamContact(CompiledContribution):
    """A contact of elements with each other.

    Parameters
    ----------
    place : (n, 4, dim) int32
        Indices of position and slope at both ends of each element.
    slot : (n, 2 dim (4 dim + 1)) int32
        Pairs of these coordinates in the matrix.
    length, radius : (n,) float
        Lengths of the elements, distances of their surfaces from their axes [m].
    straight, group : (n,) int32
        Whether an element has no slopes; the body it belongs to.
    tips : (n, 2) int32
        Whether no other element continues the axis at either end.
    near_start, near : (n + 1,) int32, (k,) int32
        Elements that do not touch an element, because they are its neighbours along the axis.
    within : bool
        Whether elements of a group touch each other.
    stiffness : float
        Force per length and penetration [N/m2].
    """

    cdef Data data

    def __cinit__(self, place, slot, length, radius, straight, group, tips, near_start, near,
                  bint within, double stiffness):
        cdef Data *data = &self.data
        cdef Search *search = &data.search
        cdef ptrdiff_t n = len(length)
        data.n, data.dim, data.stiffness = n, place.shape[2], stiffness
        data.place, data.slot, data.length = integers(place), integers(slot), reals(length)
        data.straight, data.tips = integers(straight), integers(tips)
        search.n, search.radius, search.group = n, reals(radius), integers(group)
        search.within, search.near_start, search.near = within, integers(near_start), integers(near)
        search.skin = 2.0 * max(radius)
        search.box = self.copy(np.zeros(6 * n))
        data.tight = self.copy(np.zeros(6 * n))
        data.now, data.push = self.copy(np.zeros(12 * n)), self.copy(np.zeros(12 * n))
        data.begin, data.halfway = self.copy(np.zeros(12 * n)), self.copy(np.zeros(12 * n))
        data.end, data.middle = self.copy(np.zeros(12 * n)), self.copy(np.zeros(12 * n))
        self.interface.context = data
        self.interface.residual, self.interface.between = residual, between
        self.interface.matrix, self.interface.energy = matrix, energy
        self.interface.admits = admits

    def __dealloc__(self):
        cdef Data *data = &self.data
        free(data.search.cell)
        free(data.search.bucket)
        free(data.search.order)
        free(data.search.pair)
        free(data.at_now.touch)
        free(data.at_begin.touch)
        free(data.at_halfway.touch)
        free(data.at_end.touch)

    def energy(self, const double[::1] q):
        """Return the potential of the pressures [J]."""
        return energy(&self.data, &q[0])

    def touches(self, const double[::1] q):
        """Return the Gauss points in contact.

        Returns
        -------
        elements : (k, 2) int
            Elements of the points and of their feet.
        places : (k, 2) float
            Their relative positions in these elements, from 0 to 1.
        force : (k, dim) float
            Force on the point, and with the other sign on its foot [N].
        depth : (k,) float
            Penetrations [m].
        """
        cdef Data *data = &self.data
        cdef const Touch *each
        cdef ptrdiff_t k, c, dim = data.dim
        set_points(data, &q[0], data.now)
        if not cover(&data.search, data.now, NULL) or not collect(data, data.now, &data.at_now):
            raise ValueError(CROWDED)
        k = data.at_now.n
        elements, places = np.zeros((k, 2), np.int32), np.zeros((k, 2))
        force, depth = np.zeros((k, dim)), np.zeros(k)
        cdef int32_t[:, ::1] e_view = elements
        cdef double[:, ::1] p_view = places, f_view = force
        cdef double[::1] d_view = depth
        for k in range(data.at_now.n):
            each = data.at_now.touch + k
            e_view[k, 0], e_view[k, 1] = each.a, each.b
            p_view[k, 0], p_view[k, 1] = each.z, each.u
            d_view[k] = each.e
            for c in range(dim):
                f_view[k, c] = each.stiffness * each.e * each.n[c]
        return elements, places, force, depth

    def pairs(self, const double[::1] q):
        """Return the listed pairs of elements ``(k, 2)``, which include all that touch."""
        cdef Data *data = &self.data
        cdef ptrdiff_t k
        set_points(data, &q[0], data.now)
        if not cover(&data.search, data.now, NULL):
            raise ValueError(CROWDED)
        return np.array([(data.search.pair[2 * k], data.search.pair[2 * k + 1])
                         for k in range(data.search.n_pairs)], dtype=np.int32).reshape(-1, 2)

    def admits(self, const double[::1] q0, const double[::1] q1):
        """Return whether a step between two states lets no axes pass through each other."""
        return bool(admits(&self.data, &q0[0], &q1[0]))

    @property
    def renewals(self):
        """Number of lists of pairs that have been made."""
        return self.data.search.renewals


cdef void fail(const Data *self, double *r) noexcept nogil:
    """Make a residual undefined, so that its step is not accepted."""
    cdef ptrdiff_t k
    for k in range(4 * self.n * self.dim):
        r[self.place[k]] = NAN


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    cdef Data *self = <Data *>context
    cdef const Touch *each
    cdef ptrdiff_t k
    set_points(self, x.q, self.now)
    if not cover(&self.search, self.now, NULL) or not collect(self, self.now, &self.at_now):
        fail(self, r)
        return
    if self.at_now.n == 0:
        return
    memset(self.push, 0, 12 * self.n * sizeof(double))
    for k in range(self.at_now.n):
        each = self.at_now.touch + k
        push(self, each, each.stiffness * each.e)
    distribute(self, r)


cdef double energy(void *context, const double *q) noexcept nogil:
    cdef Data *self = <Data *>context
    set_points(self, q, self.now)
    if not cover(&self.search, self.now, NULL) or not collect(self, self.now, &self.at_now):
        return NAN
    return stored(&self.at_now)


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    """Add the block of each element by itself; halfway a step for the mean force."""
    cdef Data *self = <Data *>context
    if part != STIFFNESS and part != MATERIAL:
        return
    set_points(self, x.q, self.now)
    if is_at(self, self.middle):
        add_blocks(self, &self.at_halfway, 2.0 * SIMPSON[1] * 0.5, values)
        add_blocks(self, &self.at_end, 2.0 * SIMPSON[2], values)
    elif is_at(self, self.begin):
        add_blocks(self, &self.at_begin, 1.0, values)
    elif is_at(self, self.end):
        add_blocks(self, &self.at_end, 1.0, values)
    elif cover(&self.search, self.now, NULL) and collect(self, self.now, &self.at_now):
        add_blocks(self, &self.at_now, 1.0, values)
