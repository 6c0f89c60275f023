# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Residual, matrix and energies of a system: sums over its contributions."""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.stdint cimport int64_t
from libc.stdlib cimport calloc, free

import numpy as np


include "../../abi/system_abi.pxi"
include "../../abi/vectors.pxi"


cdef ptrdiff_t MAX_STORED_MASSES = 250_000  # matrix entries (2 MB); more masses are recomputed


cdef struct Flat:
    ptrdiff_t n_contributions
    const ancf_contribution **contributions
    ptrdiff_t n_all, n_multipliers, n_values
    ptrdiff_t n_parts  # threads for vector operations
    bint damped
    bint tunes  # whether an energy depends on amplitudes
    const double *mass_values  # of the matrix; NULL if there are too many
    const int64_t *diagonal  # slots of the multipliers
    double regularization
    ptrdiff_t n_couplings
    ancf_coupling **couplings


cdef struct Range:
    # An array that the threads clear in parts.
    ptrdiff_t parts, n
    double *out


cdef class Assembly:
    """Assemble the equations of a system from its contributions.

    Parameters
    ----------
    n_free, n_all, n_amplitudes : int
        Number of free and of all coordinates, and of functions of time.
    indptr : (n + 1,) int64
        Columns of the matrix over coordinates and multipliers, as in `system.assembly.sparsity_pattern`.
    contributions : sequence of objects with a ``capsule`` "ancf_contribution"
        In the order in which they are added.
    """

    cdef ancf_system interface
    cdef Flat flat
    cdef object mass_values
    cdef const int64_t[::1] indptr
    cdef readonly tuple contributions
    cdef readonly object capsule

    def __cinit__(self, ptrdiff_t n_free, ptrdiff_t n_all, ptrdiff_t n_amplitudes,
                  const int64_t[::1] indptr, contributions):
        cdef Flat *flat = &self.flat
        cdef const ancf_contribution *each
        cdef bint keeps = False, works = False, steps = False, chooses = False, touches = False, presses = False
        # Kept alive: the structures below hold pointers to these.
        self.contributions, self.indptr = tuple(contributions), indptr
        flat.n_contributions = len(self.contributions)
        flat.contributions = <const ancf_contribution **>calloc(
            max(flat.n_contributions, 1), sizeof(ancf_contribution *))
        if flat.contributions == NULL:
            raise MemoryError
        for k, owner in enumerate(self.contributions):
            each = <const ancf_contribution *>PyCapsule_GetPointer(
                owner.capsule, "ancf_contribution")
            flat.contributions[k] = each
            flat.damped |= each.damped
            flat.tunes |= each.tune != NULL
            keeps |= each.n_memory > 0
            self.interface.n_history += each.n_history
            works |= each.work != NULL
            steps |= each.set_step != NULL
            chooses |= each.admits != NULL
            touches |= each.contacts_changed != NULL
            presses |= each.add_impulses != NULL
        flat.couplings = <ancf_coupling **>calloc(
            max(flat.n_contributions, 1), sizeof(ancf_coupling *))
        if flat.couplings == NULL:
            raise MemoryError
        flat.n_all, flat.n_multipliers = n_all, len(indptr) - 1 - n_free
        flat.n_values, flat.n_parts = indptr[len(indptr) - 1], 1
        flat.diagonal = &indptr[n_free]
        if flat.n_values <= MAX_STORED_MASSES:
            self.mass_values = self.mass
            flat.mass_values = first(self.mass_values)
        self.interface.context = flat
        self.interface.n_free, self.interface.n_all = n_free, n_all
        self.interface.n_multipliers = flat.n_multipliers
        self.interface.n_values = flat.n_values + self.reserve()
        self.interface.add = add
        self.interface.n_amplitudes = n_amplitudes
        self.interface.damped = flat.damped
        self.interface.residual, self.interface.matrix = residual, matrix
        self.interface.material = material
        self.interface.inertia, self.interface.energies = inertia, energies
        if n_amplitudes > 0 or works:
            self.interface.load_work, self.interface.load_reach = load_work, load_reach
        self.interface.residual_between = residual_between
        if keeps:
            self.interface.begin, self.interface.accept = begin, accept
        self.interface.history = history
        if steps:
            self.interface.set_step = set_step
        if chooses:
            self.interface.admits = admits
        if touches:
            self.interface.contacts_changed = contacts_changed
        if presses:
            self.interface.add_impulses = add_impulses
            self.interface.end_impulses = end_impulses
        self.capsule = PyCapsule_New(&self.interface, "ancf_system", NULL)

    def __dealloc__(self):
        free(self.flat.contributions)
        free(self.flat.couplings)

    cdef ptrdiff_t reserve(self) except -1:
        """Give each coupling its range of values; return the number of all."""
        cdef Flat *flat = &self.flat
        cdef ancf_coupling *each
        cdef ptrdiff_t total = 0
        for owner in self.contributions:
            capsule = getattr(owner, "coupling", None)
            if capsule is None:
                continue
            each = <ancf_coupling *>PyCapsule_GetPointer(capsule, "ancf_coupling")
            each.first = flat.n_values + 1 + total
            total += owner.max_pairs * each.size
            flat.couplings[flat.n_couplings] = each
            flat.n_couplings += 1
        return total

    cdef bint uses_couplings(self):
        return self.flat.n_couplings > 0 and self.flat.couplings[0].used

    def use_couplings(self, bint used):
        """Set whether matrices contain the blocks of pairs of elements."""
        cdef ptrdiff_t k
        for k in range(self.flat.n_couplings):
            self.flat.couplings[k].used = used

    def set_regularization(self, double value):
        """Set epsilon of the constraint block, in the units of the scaled matrix [1/kg]."""
        self.flat.regularization = value

    def set_threads(self, ptrdiff_t threads):
        """Set the number of threads for vector operations."""
        self.flat.n_parts = threads

    @property
    def threads(self):
        """Number of threads for vector operations."""
        return self.flat.n_parts

    @property
    def tunes(self):
        """True if energies depend on amplitudes."""
        return bool(self.flat.tunes)

    @property
    def damped(self):
        """True if any force depends on velocities."""
        return bool(self.flat.damped)

    def check(self):
        """Raise the error of the last call of a user function, if there was one."""
        for each in self.contributions:
            error = getattr(each, "error", None)
            if error is not None:
                raise error

    def forget(self):
        """Reset the errors of user functions."""
        for each in self.contributions:
            if hasattr(each, "forget"):
                each.forget()

    @property
    def memory(self):
        """History variables of the contributions, kept between accepted steps, a copy ``(k,)``."""
        cdef const ancf_contribution *each
        cdef ptrdiff_t k, i
        out = []
        for k in range(self.flat.n_contributions):
            each = self.flat.contributions[k]
            for i in range(each.n_memory):
                out.append(each.memory[i])
        return np.array(out, dtype=float)

    @memory.setter
    def memory(self, const double[::1] values):
        cdef const ancf_contribution *each
        cdef ptrdiff_t k, i, n = 0
        if len(values) != len(self.memory):
            raise ValueError(f"memory has {len(self.memory)} numbers, got {len(values)}")
        for k in range(self.flat.n_contributions):
            each = self.flat.contributions[k]
            for i in range(each.n_memory):
                each.memory[i] = values[n]
                n += 1

    @property
    def n_history(self):
        """Number of history variables that are saved with each state."""
        return self.interface.n_history

    @property
    def history(self):
        """History variables that are saved with each state, a copy ``(n_history,)``."""
        out = np.zeros(self.interface.n_history + 1)
        cdef double[::1] view = out
        history(&self.flat, &view[0])
        return out[:-1]

    def set_step(self, double dt):
        """Set the time since the last accepted state [s], 0 outside of a step."""
        set_step(&self.flat, dt)

    def begin(self, const double[::1] q):
        """Set the internal variables for a state at rest, without history."""
        cdef double[::1] rest = np.zeros(self.flat.n_all)
        cdef ancf_state x
        set_state(&x, &q[0], &rest[0], NULL, NULL, NULL)
        begin(&self.flat, &x)

    def accept(self, const double[::1] q):
        """Update the history variables to accepted coordinates."""
        cdef ancf_state x
        set_state(&x, &q[0], NULL, NULL, NULL, NULL)
        accept(&self.flat, &x)

    @property
    def mass(self):
        """Values of the mass matrix on the pattern, lower triangle [kg, kg m, kg m^2]."""
        # One extra entry, which receives the contributions of fixed coordinates.
        values = np.zeros(self.flat.n_values + 1)
        cdef double[::1] view = values
        cdef ancf_state x
        set_state(&x, &view[0], NULL, NULL, NULL, NULL)
        add_part(&self.flat, MASS, &x, &view[0])
        return values[: self.flat.n_values]

    def residual(self, const double[::1] q, const double[::1] v, const double[::1] a,
                 const double[::1] lam, const double[::1] dead_load, const double[::1] amplitudes):
        """Return ``r (n_all,)`` [N, N m] and ``phi (m,)`` [m]."""
        r, phi = np.empty(self.flat.n_all), np.empty(self.flat.n_multipliers)
        cdef double[::1] r_view = r, phi_view = phi
        residual(&self.flat, &q[0], &v[0], &a[0], first(lam), &dead_load[0], first(amplitudes),
                 &r_view[0], first(phi_view))
        self.check()
        return r, phi

    def residual_between(self, const double[::1] q0, const double[::1] q1, const double[::1] v,
                         const double[::1] a, const double[::1] lam, const double[::1] dead_load,
                         const double[::1] amplitudes):
        """Return ``r (n_all,)`` [N, N m] between two states and ``phi (m,)`` [m] at the second."""
        r, phi = np.empty(self.flat.n_all), np.empty(self.flat.n_multipliers)
        cdef double[::1] r_view = r, phi_view = phi
        cdef double[::1] q = 0.5 * (np.asarray(q0) + q1)
        residual_between(&self.flat, &q0[0], &q1[0], &q[0], &v[0], &a[0], first(lam),
                         &dead_load[0], first(amplitudes), &r_view[0], first(phi_view))
        self.check()
        return r, phi

    def matrix(self, double mass_factor, double stiffness_factor, const double[::1] q,
               const double[::1] lam, const double[::1] amplitudes, *, double damping_factor=0.0,
               const double[::1] v=None, out=None):
        """Return the values ``(n_values,)`` of the matrix, in ``out (n_values + 1,)`` if given."""
        values = np.empty(self.flat.n_values + 1) if out is None else out
        cdef double[::1] view = values
        cdef bint used = self.uses_couplings()
        self.use_couplings(False)
        matrix(&self.flat, mass_factor, stiffness_factor, damping_factor, &q[0],
               first(v), first(lam), first(amplitudes), &view[0])
        self.use_couplings(used)
        self.check()
        return values[: self.flat.n_values]

    def coupled_matrix(self, double mass_factor, double stiffness_factor, const double[::1] q,
                       const double[::1] lam, const double[::1] amplitudes, *,
                       double damping_factor=0.0, const double[::1] v=None):
        """Return the values of the matrix and of its blocks of touching elements, for a `CoupledSeed`."""
        values = np.zeros(self.interface.n_values + 1)
        cdef double[::1] view = values
        matrix(&self.flat, mass_factor, stiffness_factor, damping_factor, &q[0],
               first(v), first(lam), first(amplitudes), &view[0])
        self.check()
        return values

    def material(self, double mass_factor, double stiffness_factor, const double[::1] q, *,
                 double damping_factor=0.0, out=None):
        """Return the matrix with only the material part of the stiffness; as `matrix`."""
        values = np.empty(self.flat.n_values + 1) if out is None else out
        cdef double[::1] view = values
        cdef bint used = self.uses_couplings()
        self.use_couplings(False)
        material(&self.flat, mass_factor, stiffness_factor, damping_factor, &q[0], &view[0])
        self.use_couplings(used)
        return values[: self.flat.n_values]

    def load_work(self, const double[::1] q0, const double[::1] amplitudes0, const double[::1] q1,
                  const double[::1] amplitudes1, *, const double[::1] v0=None,
                  const double[::1] v1=None):
        """Return the work of time-dependent loads from one state to another [J]."""
        cdef double[::1] scratch = np.empty(self.flat.n_all)
        cdef ancf_state x0, x1
        set_state(&x0, &q0[0], first(v0), NULL, NULL, first(amplitudes0))
        set_state(&x1, &q1[0], first(v1), NULL, NULL, first(amplitudes1))
        return load_work(&self.flat, &x0, &x1, &scratch[0])

    def load_reach(self, const double[::1] q0, const double[::1] q1,
                   const double[::1] amplitudes):
        """Return an upper bound of the work of loads of any signs between two states [J]."""
        cdef double[::1] scratch = np.empty(self.flat.n_all)
        return load_reach(&self.flat, &q0[0], &q1[0], first(amplitudes), &scratch[0])

    def force(self, const double[::1] q):
        """Return the force ``Q(q)`` at rest and without loads, shape (n_all,) [N, N m]."""
        cdef double[::1] rest = np.zeros(self.flat.n_all)
        cdef double[::1] none = np.zeros(
            1 + max(self.flat.n_multipliers, self.interface.n_amplitudes))
        r, phi = np.empty(self.flat.n_all), np.empty(1 + self.flat.n_multipliers)
        cdef double[::1] r_view = r, phi_view = phi
        residual(&self.flat, &q[0], &rest[0], NULL, &none[0], &rest[0], &none[0], &r_view[0],
                 &phi_view[0])
        return r

    def inertia(self, const double[::1] a):
        """Return ``M a`` over all coordinates, shape (n_all,) [N, N m]."""
        out = np.empty(self.flat.n_all)
        cdef double[::1] view = out
        inertia(&self.flat, &a[0], &view[0])
        return out

    def damping(self, const double[::1] q, const double[::1] v):
        """Return the damping force, shape (n_all,) [N, N m]."""
        out = np.zeros(self.flat.n_all)
        cdef double[::1] view = out
        add_damping(&self.flat, &q[0], &v[0], &view[0])
        return out

    def strain_energy(self, const double[::1] q, const double[::1] amplitudes=None):
        """Return the energy of elements and springs [J], by default with the last amplitudes."""
        tune(&self.flat, first(amplitudes))
        return elastic(&self.flat, &q[0])


cdef inline const double *first(const double[::1] values) noexcept nogil:
    return &values[0] if values is not None and values.shape[0] > 0 else NULL


include "parallel_sums.pxi"
