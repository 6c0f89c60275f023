# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Contact of the axes of elements with each other.

A point of one axis at the distance |d| from its foot on another one has the penetration
e = reach - |d|, and a pressure k e along d / |d|.  It is integrated where e is positive, by Gauss
points between the ends of each overlap of two elements, on both axes, which halves its stiffness unless
one is bent around the other.
The energy k e^2 / 2 is zero at these ends, so they do not contribute to its derivative.

Between two states the force is its mean over the straight path between them, by Simpson's rule, along
the vectors d halfway, and a correction without momentum that makes its work the change of the energy.
Other implicit schemes, which generate energy in impacts that their steps do not resolve, take the
pressure k (e + theta a) where it is positive, with the approach a of both places in the step and
theta = min(1, (STEPS_PER_IMPACT dt / impact_time)^2).
"""
from ancfsparse.errors import InputError

include "../../contribution.pxi"
include "../contact/shared_rules.pxi"
include "geometry/axis_overlap.pxi"
include "geometry/side_weights.pxi"
include "geometry/pair_search.pxi"
include "touching_points.pxi"
include "matrix/coupled_pairs.pxi"
include "restitution.pxi"
include "mean_forces.pxi"
include "bristles/forces.pxi"
include "bristles/history.pxi"
include "bristles/tables.pxi"
include "sliding.pxi"
include "losses.pxi"
include "separation.pxi"
include "matrix/contact_matrix.pxi"
include "accepted_states.pxi"

CROWDED = (f"an element has more than {MOST_PER_ELEMENT} others within reach on average: take longer "
           "elements, or a smaller radius")


cdef enum:
    N_DEEPEST = 5  # numbers of the deepest point


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
    straight, side, body : (n,) int32
        Whether an element has no slopes; the sides it is on, 1, 2 or 3 for both; its body.
    tips : (n, 2) int32
        Whether no other element continues the axis at either end.
    near_start, near : (n + 1,) int32, (k,) int32
        Elements that do not touch an element, because they are its neighbours along the axis.
    mass : (n,) float
        Masses per length of the elements [kg/m].
    stiffness : float
        Force per length and penetration [N/m2].
    friction, slip_speed, friction0 : float
        Kinetic coefficient [-], slip speed, 0 with bristles [m/s], and their static coefficient [-].
    grip : float
        Tangential stiffness of the bristles over the stiffness [-].
    following : (n, 2) int32
        Elements that continue the axis of an element before and after it, or -1.
    n_slots : int
        Number of pairs that can have a bristle, 0 without them.
    settling : float
        Twice the damping ratio of bodies on bristles with a static coefficient [-].
    restitution : float
        Coefficient of restitution eps, 0 for undamped pressures [-].
    slow : float
        Rate of penetrations below which the damping is less, over that of impacts [-].
    body_mass : (k,) float
        Masses of the bodies [kg].
    """

    cdef Data data
    cdef readonly object coupling
    cdef readonly ptrdiff_t max_pairs
    cdef int32_t[::1] first_bristle, first_pair

    def __cinit__(self, place, slot, length, radius, straight, side, body, tips, near_start,
                  near, mass, double stiffness, double friction, double slip_speed,
                  double friction0, double grip, following, ptrdiff_t n_slots, double settling,
                  double restitution, double slow, body_mass):
        cdef Data *data = &self.data
        cdef Search *search = &data.search
        cdef ptrdiff_t n = len(length)
        data.n, data.dim, data.stiffness = n, place.shape[2], stiffness
        data.place, data.slot, data.length = integers(place), integers(slot), reals(length)
        data.straight, data.tips, data.mass = integers(straight), integers(tips), reals(mass)
        data.friction, data.slip_speed, data.dt = friction, slip_speed, 0.0
        data.friction0, data.settling = friction0, settling
        data.body, data.body_mass = integers(body), reals(body_mass)
        self.first_pair = np.full(len(body_mass), -1, np.int32)
        data.bodies.first = &self.first_pair[0]
        data.gamma, data.slow = damped_share(restitution), slow
        search.n, search.radius, search.side = n, reals(radius), integers(side)
        search.near_start, search.near = integers(near_start), integers(near)
        search.skin = 2.0 * max(radius)
        search.box = self.copy(np.zeros(6 * n))
        data.tight = self.copy(np.zeros(6 * n))
        data.now, data.push = self.copy(np.zeros(12 * n)), self.copy(np.zeros(12 * n))
        data.begin, data.halfway = self.copy(np.zeros(12 * n)), self.copy(np.zeros(12 * n))
        data.end, data.middle = self.copy(np.zeros(12 * n)), self.copy(np.zeros(12 * n))
        data.grip = grip if friction > 0.0 and slip_speed == 0.0 else 0.0
        data.n_slots, data.has_two = n_slots, data.grip > 0.0 and friction0 > friction
        data.width = 2 + data.dim + data.has_two
        self.interface.n_history = n_slots * data.width + N_LOSSES
        data.slots = self.copy(np.zeros(self.interface.n_history + N_DEEPEST + 36 * n))
        data.following, data.interval = integers(following), 0.0
        self.first_bristle = np.zeros(n, np.int32)
        data.first_bristle = &self.first_bristle[0]
        data.deepest = data.slots + self.interface.n_history
        data.spent = data.deepest - N_LOSSES
        data.before = data.deepest + N_DEEPEST
        data.start, data.ahead = data.before, self.copy(np.zeros(12 * n))
        data.braked, data.rubbed = data.before + 12 * n, data.before + 24 * n
        data.speed, data.braking = self.copy(np.zeros(12 * n)), self.copy(np.zeros(12 * n))
        self.set_up_coupling()
        self.divide(1)
        self.interface.context = data
        self.interface.residual, self.interface.between = residual, between
        self.interface.matrix, self.interface.energy = matrix, energy
        self.interface.n_memory = self.interface.n_history + N_DEEPEST
        self.interface.n_memory += 36 * n if friction > 0.0 else 24 * n
        self.interface.memory = data.slots
        self.interface.damped = data.gamma > 0.0 or slip_speed > 0.0 and friction > 0.0
        self.interface.begin, self.interface.accept = begin, accept
        if friction > 0.0:
            self.interface.work = work
        self.interface.set_step, self.interface.admits = set_step, admits
        self.interface.contacts_changed = contacts_changed

    def divide(self, ptrdiff_t threads):
        """Distribute the pairs among threads; forces are the same for any number of them."""
        cdef Touches *more = <Touches *>calloc(threads, sizeof(Touches))
        if more == NULL:
            raise MemoryError
        self.free_parts()
        self.data.of_part, self.data.n_parts = more, threads

    cdef free_parts(self):
        cdef ptrdiff_t part
        for part in range(self.data.n_parts):
            free(self.data.of_part[part].touch)
        free(self.data.of_part)

    cdef set_up_coupling(self):
        cdef Coupling *coupling = &self.data.coupling
        cdef ptrdiff_t n = self.data.n
        self.max_pairs = coupling.room = MOST_COUPLED * n
        coupling.pair = <int32_t *>calloc(2 * coupling.room, sizeof(int32_t))
        coupling.first = <int32_t *>calloc(n, sizeof(int32_t))
        coupling.next = <int32_t *>calloc(coupling.room, sizeof(int32_t))
        coupling.touches = <int32_t *>calloc(coupling.room, sizeof(int32_t))
        if (coupling.pair == NULL or coupling.first == NULL or coupling.next == NULL
                or coupling.touches == NULL):
            raise MemoryError
        memset(coupling.first, -1, n * sizeof(int32_t))
        coupling.list.pair, coupling.list.size = coupling.pair, 16 * self.data.dim**2
        self.coupling = PyCapsule_New(&coupling.list, "ancf_coupling", NULL)

    @property
    def coupled_pairs(self):
        """Pairs of elements that the matrix couples now, ``(k, 2)``, the lower one first."""
        cdef ptrdiff_t n = self.data.coupling.list.n
        if n == 0:
            return np.empty((0, 2), np.int32)
        return np.array(<int32_t[:n, :2]>self.data.coupling.pair)

    def __dealloc__(self):
        cdef Data *data = &self.data
        free(data.search.entry)
        free(data.search.bucket)
        free(data.search.pair)
        free(data.at_now.touch)
        free(data.at_begin.touch)
        free(data.at_halfway.touch)
        free(data.at_end.touch)
        free(data.coupling.pair)
        free(data.coupling.first)
        free(data.coupling.next)
        free(data.coupling.touches)
        free(data.bristle)
        free(data.bodies.pair)
        self.free_parts()

    def energy(self, const double[::1] q):
        """Return the potential of the pressures [J]."""
        return energy(&self.data, &q[0])

    def touches(self, const double[::1] q, const double[::1] v=None):
        """Return the Gauss points in contact, with the forces of a restitution for velocities v.

        Returns
        -------
        elements : (k, 2) int
            Elements of the points and of their feet.
        places : (k, 2) float
            Their relative positions in these elements, from 0 to 1; of feet next to a node a little
            beyond.
        force : (k, dim) float
            Force on the point, and with the other sign on its foot [N].
        depth : (k,) float
            Penetrations [m].
        """
        cdef Data *data = &self.data
        cdef const double *velocities = NULL
        cdef const Touch *each
        cdef ptrdiff_t k, c, dim = data.dim
        set_points(data, &q[0], data.now)
        if not cover(&data.search, data.now, NULL) or not collect(
                data, data.now, NULL, &data.at_now):
            raise InputError(CROWDED)
        if v is not None:
            velocities = &v[0]
        restrain_state(data, &data.at_now, velocities)
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
                f_view[k, c] = pressure(each) * each.n[c]
        return elements, places, force, depth

    def friction(self, const double[::1] q, const double[::1] v, const double[::1] history):
        """Return friction on the points of `touches` (k, dim) [N], with the other sign on their feet.

        Bristles have their history variables (n_history,), and no force if these are empty.
        """
        cdef Data *data = &self.data
        force = np.zeros((len(self.touches(q, v)[0]), data.dim))
        cdef double[:, ::1] view = force
        if data.grip > 0.0:
            if len(history):
                set_bristle_forces(data, history, force)
            return force
        set_points(data, &v[0], data.speed)
        if data.friction > 0.0:
            set_sliding_forces(data, view)
        return force

    @property
    def deepest(self):
        """Largest penetration in the accepted states of a run [m], and as `touches` its place."""
        cdef const double *x = self.data.deepest
        return x[0], (int(x[1]), int(x[2])), (x[3], x[4])

    def forget_deepest(self):
        """Let the largest penetration be one of the states to come."""
        self.data.deepest[0] = 0.0

    @property
    def contact_changes(self):
        """Number of accepted steps at whose end more or fewer points touch than at their start."""
        return self.data.changes

    @property
    def is_sticking(self):
        """True if bristles stick in the matrix of a state, outside of steps."""
        return self.data.is_sticking

    @is_sticking.setter
    def is_sticking(self, bint value):
        self.data.is_sticking = value and self.data.grip > 0.0

    def begin_equilibria(self, const double[::1] q):
        """Let bristles be deflected by displacements from coordinates on."""
        cdef Data *data = &self.data
        if data.grip > 0.0:
            memset(data.slots, 0, self.interface.n_history * sizeof(double))
            memset(data.rubbed, 0, 12 * data.n * sizeof(double))
            set_points(data, &q[0], data.before)
            data.is_static, data.ended = True, False
            data.dt, data.interval = 0.0, INFINITY

    def accept_equilibrium(self, const double[::1] q):
        """Update the deflections of bristles to an equilibrium."""
        cdef ancf_state x
        if self.data.is_static:
            x.q, x.v, self.data.stepped = &q[0], NULL, False
            work(&self.data, NULL, &x, NULL)
            self.data.is_static = False
            accept(&self.data, &x)
            self.data.is_static = True

    def end_equilibria(self):
        """Let bristles keep their deflections."""
        self.data.is_static, self.data.interval = False, 0.0

    def bristles(self, const double[::1] q):
        """Return the bristles in an equilibrium, or of a state that sticks.

        Returns
        -------
        elements : (k, 2) int
            Both elements.
        weights : (k, 2, 4) float
            Of positions and slopes at the ends of each.
        blocks : (k, dim, dim) float
            Derivatives of the friction by relative displacements [N/m].
        sliding : (k, dim) float
            Its derivatives by the normal force in equilibria, zero where bristles stick.
        """
        return bristle_table(&self.data, &q[0])

    def pairs(self, const double[::1] q):
        """Return the listed pairs of elements ``(k, 2)``, which include all that touch."""
        cdef Data *data = &self.data
        cdef ptrdiff_t k
        set_points(data, &q[0], data.now)
        if not cover(&data.search, data.now, NULL):
            raise InputError(CROWDED)
        return np.array([(data.search.pair[2 * k], data.search.pair[2 * k + 1])
                         for k in range(data.search.n_pairs)], dtype=np.int32).reshape(-1, 2)

    @property
    def error(self):
        """The error of a step with more pairs than the history has slots for, or None."""
        if self.data.crowded == 0:
            return None
        return InputError(
            f"{self.data.crowded} pairs of elements touch each other, and friction that sticks is "
            f"for {self.data.n_slots}, {self.data.n_slots // self.data.n} per element on average: "
            "take longer elements, or give contact a slip_speed")

    def forget(self):
        """Reset this error."""
        self.data.crowded = 0

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
    set_points(self, x.q, self.end)
    self.stepped, self.ended = False, list_damped(self, self.end, &self.at_end)
    if not self.ended:
        fail(self, r)
        return
    if self.at_end.n == 0:
        self.n_bristles = 0  # the matrix has none either
        return
    list_pairs(self, &self.at_end)
    restrain_state(self, &self.at_end, x.v)
    memset(self.push, 0, 12 * self.n * sizeof(double))
    push_all(self, &self.at_end, 1.0, self.push)
    if self.grip > 0.0:
        if not set_bristles(self, False):
            fail(self, r)
            return
        push_bristles(self, self.push)
    elif self.friction > 0.0 and x.v != NULL:
        set_points(self, x.v, self.speed)
        rub(self, &self.at_end, 1.0, self.push)
    distribute(self, r)


cdef double energy(void *context, const double *q) noexcept nogil:
    cdef Data *self = <Data *>context
    set_points(self, q, self.now)
    if not cover(&self.search, self.now, NULL) or not collect(self, self.now, NULL, &self.at_now):
        return NAN
    return stored(&self.at_now)
