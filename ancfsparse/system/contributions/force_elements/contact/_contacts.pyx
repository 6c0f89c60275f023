# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Contact of quadrature points with an obstacle, fixed or on a rigid body.

A point x is at d = A (x - base) from the base of the obstacle, which is fixed or a point of a rigid
body with the orthonormal vectors u_i; then x - base is a linear function of the coordinates of both
bodies.  Surfaces touch where the penetration e = reach - |d| is positive, or reach - n.(x - base)
for a plane; other shapes, and shapes that turn with a body, are in geometry/shapes.pxi.  The
pressure p(e) of contact_law.pxi acts along n = d / |d|, and friction along the surface
(sliding.pxi, bristles.pxi).

Between two states the pressure is the discrete gradient (W(e1) - W(e0)) / (e1 - e0) along
(d0 + d1) / (|d0| + |d1|), whose work is the change of the energy W.  Other implicit schemes, which
generate energy in impacts that their steps do not resolve, take p(e1 + theta (e1 - e0)) with e0
of the last accepted state and theta = min(1, (STEPS_PER_IMPACT dt / impact_time)^2).
"""
from libc.math cimport INFINITY, NAN, sqrt, tan, tanh
from libc.stdint cimport int64_t
from libc.string cimport memcpy, memset

include "../../contribution.pxi"
include "../../points.pxi"
include "shared_rules.pxi"
include "contact_law.pxi"
include "geometry/point_positions.pxi"

cdef struct Data:
    Points points
    Groups groups
    const int32_t *slot
    const int64_t *first_slot  # of each group
    const double *stiffness  # of each point, times its length [N/m]
    const double *rate  # of each point: STEPS_PER_IMPACT over the duration of an impact [1/s]
    double gamma  # share of the pressure that changes its sign in an impact, 0 without restitution
    const double *slow  # of each point: speed over penetration below which it does less [1/s]
    double *z  # deflections of the bristles in the last accepted state, (n, dim) [m]
    double *slides  # of each point, 1 if its bristle slides there, otherwise 0; null without `friction0`
    double *drag  # then friction on the points in that state, with the damping of bristles, (n, 3) [N]
    double *pull  # and at the end of the step of the last `work`
    # Since the start of the run [J]: work that turning supplies, losses by friction and by the damping
    # of impacts; saved with the states.
    double *spent
    double *before  # penetrations there [m]
    double *last  # and forces of the pressures there [N]
    # Of each point, see impact_gains.pxi: energy gained in the present contact [J], impulse in the step [N s].
    double *gain
    double *impulse
    double supplied, rubbed  # work of turning and loss by friction in the step of the last `work` [J]
    double *damped  # of each point: loss by the damping of impacts in the last accepted step [J]
    double *deepest  # penetration of an accepted state that is largest over its layer [m], its point
    ptrdiff_t changes  # accepted steps at whose end other points touch than at their start
    bint is_mean  # whether the last residual was that between two states
    double dt  # length of the step, 0 outside of one and where impacts are not damped [s]
    # Vectors and matrices in space, with zeros for the third direction in the plane.
    const double *base
    const double *normal  # of a plane
    const double *projector
    const double *spin  # of the velocity of the surface [rad/s]
    double *weights  # workspace for `weigh`, of each part
    ptrdiff_t n_weights
    const int32_t *turning  # of each coordinate of the points, i + 1 if it is of a vector u_i
    bint on_body  # whether the obstacle is on a body: any of `turning` is not zero
    bint is_round
    bint is_flat  # whether it is a plane at rest: all points have one normal, and places do not matter
    bint is_plain  # whether residual/points_in_lanes.pxi applies
    bint has_frame  # whether geometry/shapes.pxi applies, with the fields up to `frame_moves`
    const double *frame  # axes of the obstacle as rows, along its body, (dim, dim)
    const double *bounds  # of the core in it, (2, dim) [m]
    double ring  # radius of a core that is a circle, otherwise 0 [m]
    const double *grid  # spline coefficients of a sampled distance, or null
    ptrdiff_t[3] shape  # numbers of them
    double cell  # spacing of the grid [m]
    bint frame_moves  # whether it is on a body
    const double *reach  # of each point: distance from the base or core at which surfaces touch [m]
    const double *layer  # of each point: thickness of the layer in which the pressure begins [m]
    double friction, slip_speed
    double friction0  # static coefficient of friction
    double grip  # tangential stiffness of bristles over the stiffness, 0 without them
    const double *settling  # of each point: damping of a bristle over its stiffness [s]
    double interval  # since the last accepted state [s]
    bint is_static  # whether states are equilibria, which displacements since the last one deflect
    bint is_sticking  # whether bristles stick in the matrix of a state, outside of steps
    double omega, turn  # angular velocity of the surface [rad/s]; 2 tan(omega dt/2) / omega [s]
    # Runs of groups of each part, then those that share coordinates with several parts.
    ptrdiff_t n_parts
    const int32_t *run_start
    const int32_t *runs  # (n_runs, 3): 0, first group and end
    ptrdiff_t n_all
    ptrdiff_t n_state  # numbers in `q0` and `x0`, 0 without bristles
    double *q0  # coordinates in the last accepted state
    double *x0  # and positions of the points in it, (n, 3) [m]
    double *share  # of each point: part of its displacement since the last equilibrium in contact
    double *trial  # of the last residual: displacements of bristles that stick, (n, 3) [m]
    # Of the last residual: penetrations where its matrix is requested, halfway a step from state to
    # state, the forces of the pressures, and their derivatives by the state that is sought.
    double *at
    double *force
    double *slope


cdef struct Place:  # of a point relative to the obstacle
    double[4] x  # position, or that relative to the base on a body, and an unused number
    double[3] d  # vector from the base
    double distance  # |d|, or that from the core of a shape with a frame
    double[3] n
    double e  # penetration
    double[3] b  # with a frame: d along the body, and the derivatives of the distance by it
    double[3] m
    double[3] g  # m in space, along the unit vector n
    double[9] u  # vectors of the body as rows


cdef in_space(values):
    """Return a vector or matrix of the plane or space in space."""
    return np.pad(values, (0, 3 - len(values)))


cdef class Contact(CompiledContribution):
    """A contact.

    Parameters
    ----------
    start, place, weight, slot
        The points as sums of coordinates, see points.pxi.
    first, term, group_place, in_row, alike
        Points with the same coordinates, see `PointSums.groups` and `PointSums.alike`.
    stiffness, impact_time : (n,) float
        Stiffness of each point [N/m], 0 if it does not touch, and the duration of an impact there [s].
    base, normal : (dim,) float
        A point of the base [m]; outward normal of a plane.
    projector, spin : (dim, dim) float
        See `Obstacle`.
    turning : (m,) int32
        Of the coordinates of the points, i + 1 for vectors u_i of the body of the obstacle.
    is_round : bool
        False for a plane.
    frame : (dim, dim) or (0, dim) float
        Axes of an obstacle with a core in them, as rows, in space or along the vectors of its body.
    bounds : (2, dim) float
        Of the core [m].
    ring : float
        Radius of a core that is a circle [m].
    grid : (k,) * dim float or None
        Spline coefficients of distances sampled on a grid; bounds are its inner nodes.
    cell : float
        Spacing of the grid [m].
    reach : (n,) float
        Distance of each point from the base at which surfaces touch [m].
    layer : (n,) float
        Thickness of the layer in which the pressure begins [m].
    friction, slip_speed, friction0 : float
        Kinetic coefficient [-], slip speed, 0 with bristles [m/s], and their static coefficient [-].
    grip, settling : float, (n,) float
        Stiffness of bristles over the stiffness [-], and their damping over their own one [s].
    restitution : float
        Coefficient of restitution eps, 0 for undamped pressures [-].
    slow : (n,) float
        Speed over penetration of each point below which the damping is less [1/s].
    n_all : int
        Number of coordinates.
    """

    cdef Data data
    cdef object runs
    cdef double[::1] workspace
    cdef const int64_t[::1] first_slot

    def __cinit__(self, start, place, weight, first, term, group_place, in_row, alike, slot,
                  stiffness, impact_time, base, normal, projector, spin, turning, bint is_round, frame,
                  bounds, double ring, grid, double cell, reach, layer,
                  double friction, double slip_speed, double friction0,
                  double grip, settling, double restitution, slow, ptrdiff_t n_all):
        cdef Data *data = &self.data
        cdef ptrdiff_t n
        take_points(&data.points, start, place, weight)
        take_groups(&data.groups, first, term, group_place, in_row, alike)
        data.slot = integers(slot)
        data.stiffness = self.copy_with_rest(stiffness, 0.0)
        data.rate, n = self.copy_with_rest(STEPS_PER_IMPACT / impact_time, 0.0), data.points.n
        data.gamma = damped_share(restitution)
        data.slow, data.settling = self.copy(slow), self.copy_with_rest(settling, 0.0)
        data.grip = grip if friction > 0.0 and slip_speed == 0.0 else 0.0
        self.interface.n_history = n * data.points.dim if data.grip > 0.0 else 0
        has_two = data.grip > 0.0 and friction0 > friction
        self.interface.n_history += n * has_two + N_LOSSES
        self.interface.n_memory = self.interface.n_history + 3 * n + 2 + 3 * n * has_two
        data.z = self.copy_with_rest(np.zeros(self.interface.n_memory), 0.0)
        data.slides = data.z + n * data.points.dim if has_two else NULL
        data.before = data.z + self.interface.n_history
        data.spent, data.damped = data.before - N_LOSSES, self.copy(np.zeros(n))
        data.last = data.before + n
        data.gain, data.impulse = data.last + n, self.copy(np.zeros(n))
        data.deepest = data.gain + n
        if has_two:
            data.drag, data.pull = data.deepest + 2, self.copy(np.zeros(3 * n))
        data.base, data.normal = self.copy(in_space(base)), self.copy(in_space(normal))
        data.projector, data.spin = self.copy(in_space(projector)), self.copy(in_space(spin))
        data.turning, data.on_body = integers(turning), np.any(turning)
        data.n_weights = np.max(np.diff(start)) + 8  # those of two parts in different cache lines
        # Pairs of the coordinates of each point of a group, in one triangle of the matrix.
        sizes = data.points.dim * np.diff(term).astype(np.int64)
        self.first_slot = np.cumsum(np.append(0, np.diff(first) * (sizes * (sizes + 1) // 2)))
        data.first_slot = &self.first_slot[0]
        data.is_round = is_round
        data.reach, data.layer = self.copy_with_rest(reach, 0.0), self.copy_with_rest(layer, 1.0)
        data.has_frame, data.ring = len(frame) > 0, ring
        data.frame_moves = data.has_frame and np.any(turning)
        if data.has_frame:
            data.frame, data.bounds = self.copy(frame), self.copy(bounds)
        if grid is not None:
            data.grid, data.cell = reals(grid), cell
            data.shape[0], data.shape[1], data.shape[2] = (*grid.shape, 1)[:3]
        data.friction, data.slip_speed, data.friction0 = friction, slip_speed, friction0
        data.at = self.copy_with_rest(np.full(n, np.nan), 0.0)
        data.force = self.copy_with_rest(np.full(n, np.nan), 0.0)
        data.slope = self.copy_with_rest(np.full(n, np.nan), 0.0)
        data.n_all = n_all if data.grip > 0.0 else 0
        data.n_state = (data.n_all + 3 * n) * (data.grip > 0.0)
        data.q0 = self.copy_with_rest(np.zeros(data.n_state), 0.0)
        data.x0 = data.q0 + data.n_all
        data.interval = data.turn = 0.0
        data.omega = np.linalg.norm(spin) / np.sqrt(2.0)
        data.is_plain = not (data.on_body or data.has_frame or data.gamma > 0.0)
        data.is_flat = not (is_round or data.has_frame or data.omega > 0.0)
        if data.grip > 0.0:
            data.trial, data.share = self.copy_with_rest(np.zeros(3 * n), 0.0), self.copy(np.ones(n))
        self.divide(np.array([0, 1, 1], np.int32), np.array([[0, 0, data.groups.n]], np.int32))
        self.interface.context, self.interface.damped = data, slip_speed > 0.0 or data.gamma > 0.0
        self.interface.residual, self.interface.between = residual, between
        self.interface.matrix, self.interface.energy = matrix, energy
        self.interface.memory = data.z
        self.interface.begin, self.interface.accept = begin, accept
        self.interface.set_step, self.interface.contacts_changed = set_step, contacts_changed
        self.interface.add_impulses, self.interface.end_impulses = add_impulses, end_impulses
        if friction > 0.0:
            self.interface.work = work

    cdef double *copy_with_rest(self, values, double rest) except NULL:
        """Return the address of a copy on cache lines, followed by what vectors read beyond its end."""
        room = np.full(len(values) + CACHE_LINE + 3 * LANES, rest)
        cdef double[::1] view = room
        cdef ptrdiff_t begin = CACHE_LINE - <ptrdiff_t>&view[0] // <ptrdiff_t>sizeof(double) % CACHE_LINE
        room[begin:begin + len(values)] = values
        self.owners.append(room)
        return &view[begin]

    def divide(self, run_start, runs):
        """Distribute the groups of points among threads, as `partition_blocks` does."""
        self.runs = run_start, runs
        self.data.n_parts = len(run_start) - 2
        self.workspace = np.zeros(self.data.n_parts * self.data.n_weights)
        self.data.weights = &self.workspace[0]
        self.data.run_start, self.data.runs = integers(run_start), integers(runs)

    @property
    def is_sticking(self):
        """True if bristles stick in the matrix of a state, outside of steps."""
        return self.data.is_sticking

    @is_sticking.setter
    def is_sticking(self, bint value):
        self.data.is_sticking = value and self.data.grip > 0.0

    def begin_equilibria(self, const double[::1] q):
        """Let bristles be deflected by displacements from coordinates on."""
        if self.data.grip > 0.0:
            hold(&self.data, &q[0])
            memset(self.data.spent, 0, N_LOSSES * sizeof(double))
            self.data.is_static = True
            approach_equilibrium(&self.data, 0.0)

    def approach_equilibrium(self, double dt):
        """Set the time since the last equilibrium, for the rotation of obstacles [s]."""
        approach_equilibrium(&self.data, dt)

    def accept_equilibrium(self, const double[::1] q):
        """Update the deflections of bristles to an equilibrium."""
        if self.data.is_static:
            follow_equilibrium(&self.data, &q[0])

    def end_equilibria(self):
        """Let bristles keep their deflections."""
        cdef ptrdiff_t k
        if self.data.is_static:
            for k in range(self.data.points.n):
                self.data.share[k] = 1.0
        self.data.is_static = False
        set_step(&self.data, 0.0)

    @property
    def deepest(self):
        """Penetration of the last run that is largest over its radius [m], and its point."""
        return self.data.deepest[0], int(self.data.deepest[1])

    def forget_deepest(self):
        """Let the largest penetration be one of the states to come."""
        self.data.deepest[0] = 0.0

    @property
    def contact_changes(self):
        """Number of accepted steps at whose end other points touch than at their start."""
        return self.data.changes

    def forces(self, const double[::1] q, const double[::1] v, const double[::1] history):
        """Return normal force and friction on every point, (2, n, dim) [N].

        Bristles have the deflections of its history variables, and none if these are empty.
        """
        cdef ptrdiff_t k, c, n = self.data.points.n, dim = self.data.points.dim
        out = np.zeros((2, n, dim))
        cdef double[:, :, ::1] view = out
        cdef Place here
        cdef double pressure
        cdef double[3] f
        cdef bint slides
        for k in range(n):
            locate(&self.data, k, &q[0], &here)
            if here.e > 0.0:
                pressure = saved_force(&self.data, k, &here, &v[0])
                for c in range(dim):
                    view[0, k, c] = pressure * leaving(&self.data, &here)[c]
                if self.data.grip > 0.0:
                    if history.shape[0] == 0:
                        continue
                    take_bristle(&self.data, &history[dim * k], &f[0])
                    slides = self.data.slides != NULL and history[dim * n + k] > 0.0
                    grip(&self.data, k, limit_if(&self.data, k, slides, pressure), &f[0])
                    for c in range(dim):
                        view[1, k, c] = f[c]
                elif self.data.friction > 0.0:
                    weigh(&self.data, k, &q[0], &q[0], &here)
                    move(&self.data, k, &v[0], &f[0])
                    rub(&self.data, &here, pressure, &f[0])
                    for c in range(dim):
                        view[1, k, c] = f[c]
        return out

    def motion(self, const double[::1] q, const double[::1] v):
        """Return sliding velocities of the points, (n, dim) [m/s], and penetrations, (n,) [m]."""
        cdef ptrdiff_t k, n = self.data.points.n, dim = self.data.points.dim
        velocities, depths = np.zeros((n, 3)), np.zeros(n)
        cdef double[:, ::1] u = velocities
        cdef double[::1] e = depths
        cdef Place here
        for k in range(n):
            locate(&self.data, k, &q[0], &here)
            weigh(&self.data, k, &q[0], &q[0], &here)
            move(&self.data, k, &v[0], &u[k, 0])
            slide(&self.data, &here, &u[k, 0])
            e[k] = here.e
        return velocities[:, :dim], depths

    def gradients(self, const double[::1] q):
        """Return the derivatives of the distance of each point by its coordinates, (m, dim) [1]."""
        cdef ptrdiff_t k, c, i
        out = np.zeros((self.data.points.m, self.data.points.dim))
        cdef double[:, ::1] view = out
        cdef const int32_t *start = self.data.points.start
        cdef Place here
        for k in range(self.data.points.n):
            locate(&self.data, k, &q[0], &here)
            for i in range(start[k], start[k + 1]):
                for c in range(self.data.points.dim):
                    view[i, c] = self.data.points.weight[i] * leaving(&self.data, &here)[c]
                    if self.data.frame_moves and self.data.turning[i]:
                        view[i, c] += here.m[self.data.turning[i] - 1] * here.d[c]
        return out

    def sliding(self, const double[::1] q):
        """Return derivatives of friction by penetrations where points slide, (n, dim) [N/m]."""
        out = np.zeros((self.data.points.n, self.data.points.dim))
        add_sliding(&self.data, &q[0], out)
        return out

    def energy(self, const double[::1] q):
        """Return the potential of the pressures [J]."""
        return energy(&self.data, &q[0])


include "residual/parts.pxi"
include "geometry/grids.pxi"
include "geometry/shapes.pxi"
include "accepted_states.pxi"
include "restitution.pxi"
include "sliding.pxi"
include "bristles.pxi"
include "residual/law_in_lanes.pxi"
include "residual/points_in_lanes.pxi"
include "residual/contact_residual.pxi"
include "contact_matrix.pxi"
include "impact_gains.pxi"
