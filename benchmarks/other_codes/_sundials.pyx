# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""SUNDIALS' integrators with the compiled forces of a system, without Python in between.

Built if the headers of SUNDIALS are found (version 6).  The state is y = (q, v) over the free
coordinates, and y' = (v, M^-1 (f - Q(q))), with the factor of M that our explicit integrators use.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer
from libc.string cimport memcpy, memset

import numpy as np

include "../../ancfsparse/abi/solver_abi.pxi"
include "../../ancfsparse/abi/signals.pxi"


cdef extern from "sundials/sundials_config.h":
    const char *SUNDIALS_VERSION

cdef extern from "sundials/sundials_context.h":
    ctypedef struct _SUNContext
    ctypedef _SUNContext *SUNContext
    int SUNContext_Create(void *, SUNContext *)
    int SUNContext_Free(SUNContext *)

cdef extern from "nvector/nvector_serial.h":
    ctypedef struct _generic_N_Vector
    ctypedef _generic_N_Vector *N_Vector
    N_Vector N_VNew_Serial(long, SUNContext)
    double *N_VGetArrayPointer_Serial(N_Vector) noexcept nogil
    void N_VDestroy_Serial(N_Vector)

cdef extern from "sundials/sundials_matrix.h":
    ctypedef enum SUNMatrix_ID:
        SUNMATRIX_CUSTOM
    ctypedef _generic_SUNMatrix *SUNMatrix
    ctypedef struct SUNMatrix_Ops "struct _generic_SUNMatrix_Ops":
        SUNMatrix_ID (*getid)(SUNMatrix) noexcept
    ctypedef struct _generic_SUNMatrix "struct _generic_SUNMatrix":
        SUNMatrix_Ops *ops
    SUNMatrix SUNMatNewEmpty(SUNContext)
    void SUNMatFreeEmpty(SUNMatrix)

cdef extern from "sundials/sundials_linearsolver.h":
    ctypedef enum SUNLinearSolver_Type:
        SUNLINEARSOLVER_DIRECT
    ctypedef _generic_SUNLinearSolver *SUNLinearSolver
    ctypedef struct SUNLinearSolver_Ops "struct _generic_SUNLinearSolver_Ops":
        SUNLinearSolver_Type (*gettype)(SUNLinearSolver) noexcept
        int (*solve)(SUNLinearSolver, SUNMatrix, N_Vector, N_Vector, double) noexcept
    ctypedef struct _generic_SUNLinearSolver "struct _generic_SUNLinearSolver":
        void *content
        SUNLinearSolver_Ops *ops
    SUNLinearSolver SUNLinSolNewEmpty(SUNContext)
    void SUNLinSolFreeEmpty(SUNLinearSolver)

cdef extern from "sunnonlinsol/sunnonlinsol_fixedpoint.h":
    ctypedef struct _generic_SUNNonlinearSolver
    ctypedef _generic_SUNNonlinearSolver *SUNNonlinearSolver
    SUNNonlinearSolver SUNNonlinSol_FixedPoint(N_Vector, int, SUNContext)
    int SUNNonlinSolFree(SUNNonlinearSolver)

ctypedef int (*Rate)(double, N_Vector, N_Vector, void *) noexcept
ctypedef int (*Setup)(double, N_Vector, N_Vector, SUNMatrix, int, int *, double, void *, N_Vector,
                      N_Vector, N_Vector) noexcept

cdef extern from "cvode/cvode.h":
    int CV_ADAMS, CV_BDF, CV_NORMAL
    void *CVodeCreate(int, SUNContext)
    int CVodeInit(void *, Rate, double, N_Vector)
    int CVodeSStolerances(void *, double, double)
    int CVodeSetUserData(void *, void *)
    int CVodeSetErrFile(void *, void *)
    int CVodeSetMaxNumSteps(void *, long)
    int CVodeSetLinearSolver(void *, SUNLinearSolver, SUNMatrix)
    int CVodeSetLinSysFn(void *, Setup)
    int CVodeSetNonlinearSolver(void *, SUNNonlinearSolver)
    int CVodeGetNumSteps(void *, long *)
    int CVode(void *, double, N_Vector, double *, int) nogil
    char *CVodeGetReturnFlagName(long)
    void CVodeFree(void **)

cdef extern from "arkode/arkode_erkstep.h":
    int ARKODE_DORMAND_PRINCE_7_4_5, ARKODE_VERNER_8_5_6, ARKODE_FEHLBERG_13_7_8
    int ARK_NORMAL
    void *ERKStepCreate(Rate, double, N_Vector, SUNContext)
    int ERKStepSStolerances(void *, double, double)
    int ERKStepSetUserData(void *, void *)
    int ERKStepSetErrFile(void *, void *)
    int ERKStepSetMaxNumSteps(void *, long)
    int ERKStepSetTableNum(void *, int)
    int ERKStepGetNumSteps(void *, long *)
    int ERKStepEvolve(void *, double, N_Vector, double *, int) nogil
    char *ERKStepGetReturnFlagName(long)
    void ERKStepFree(void **)


cdef enum:
    LOOK_EVERY = 256  # right-hand sides between two readings of the clock

cdef long MOST_STEPS = 10_000_000  # between two output times

TABLES = {
    "ARKODE 5(4)": ARKODE_DORMAND_PRINCE_7_4_5,
    "ARKODE 6(5)": ARKODE_VERNER_8_5_6,
    "ARKODE 8(7)": ARKODE_FEHLBERG_13_7_8,
}
METHODS = ("CVODE Adams", "CVODE BDF", *TABLES)
VERSION = SUNDIALS_VERSION.decode()


cdef struct Problem:
    const ancf_system *system
    const ancf_seed *mass       # factor of M
    const ancf_seed *iteration  # factor of M + gamma^2 K
    const double *dead_load
    const double *amplitudes
    const int *indptr           # lower triangle of M, K and their sums
    const int *indices
    double *q                   # all coordinates
    double *r                   # residual, padded to whole vectors
    double *mass_values
    double *stiffness_values
    double *values
    double gamma, deadline
    long evaluations, jacobians
    bint late


cdef int rate(double t, N_Vector y, N_Vector out, void *user) noexcept:
    cdef Problem *p = <Problem *>user
    cdef ptrdiff_t i, n = p.system.n_free
    cdef const double *state = N_VGetArrayPointer_Serial(y)
    cdef double *rates = N_VGetArrayPointer_Serial(out)
    p.evaluations += 1
    if p.evaluations % LOOK_EVERY == 0 and now() > p.deadline:
        p.late = True
        return -1
    memcpy(p.q, state, n * sizeof(double))
    memcpy(rates, &state[n], n * sizeof(double))
    p.system.residual(p.system.context, p.q, NULL, NULL, NULL, p.dead_load, p.amplitudes, p.r, NULL)
    p.mass.solve(p.mass.context, p.r, p.r)
    for i in range(n):
        rates[n + i] = -p.r[i]
    return 0


cdef SUNMatrix_ID matrix_id(SUNMatrix matrix) noexcept:
    return SUNMATRIX_CUSTOM


cdef SUNLinearSolver_Type solver_type(SUNLinearSolver solver) noexcept:
    return SUNLINEARSOLVER_DIRECT


cdef int setup(double t, N_Vector y, N_Vector rates, SUNMatrix matrix, int known, int *renewed,
               double gamma, void *user, N_Vector a, N_Vector b, N_Vector c) noexcept:
    """Factor M + gamma^2 K, the Schur complement of I - gamma J after elimination of q."""
    cdef Problem *p = <Problem *>user
    cdef ptrdiff_t k
    renewed[0] = not known
    if not known:
        p.jacobians += 1
        memcpy(p.q, N_VGetArrayPointer_Serial(y), p.system.n_free * sizeof(double))
        p.system.matrix(p.system.context, 0.0, 1.0, 0.0, p.q, NULL, NULL, p.amplitudes,
                        p.stiffness_values)
    p.gamma = gamma
    for k in range(p.system.n_values):
        p.values[k] = p.mass_values[k] + gamma * gamma * p.stiffness_values[k]
    return 1 if p.iteration.factor(p.iteration.context, p.values) else 0


cdef int solve(SUNLinearSolver solver, SUNMatrix matrix, N_Vector x, N_Vector b,
               double tolerance) noexcept:
    """Solve (I - gamma J) (s, w) = (b, d): (M + gamma^2 K) w = M d - gamma K b, s = b + gamma w."""
    cdef Problem *p = <Problem *>solver.content
    cdef ptrdiff_t i, n = p.system.n_free
    cdef const double *given = N_VGetArrayPointer_Serial(b)
    cdef double *out = N_VGetArrayPointer_Serial(x)
    memset(p.r, 0, n * sizeof(double))
    add_product(p, 1.0, p.mass_values, &given[n])
    add_product(p, -p.gamma, p.stiffness_values, given)
    p.iteration.solve(p.iteration.context, p.r, p.r)
    for i in range(n):
        out[i] = given[i] + p.gamma * p.r[i]
        out[n + i] = p.r[i]
    return 0


cdef void add_product(Problem *p, double factor, const double *values, const double *x) noexcept:
    """``r += factor A x`` with the lower triangle of A."""
    cdef ptrdiff_t i, j, k
    for j in range(p.system.n_free):
        for k in range(p.indptr[j], p.indptr[j + 1]):
            i = p.indices[k]
            p.r[i] += factor * values[k] * x[j]
            if i != j:
                p.r[j] += factor * values[k] * x[i]


def integrate(system, mass, iteration, pattern, const double[::1] mass_values,
              const double[::1] q0, const double[::1] y0, const double[::1] dead_load,
              const double[::1] amplitudes, const double[::1] t, str method, double rtol,
              double atol, double cap):
    """Integrate from ``t[0]``; return ``(y, seconds, evaluations, jacobians, steps, reason)``.

    Parameters
    ----------
    system : object with a ``capsule`` "ancf_system", without multipliers and damping
    mass, iteration : objects with a ``capsule`` "ancf_seed"
        Factor of the mass matrix, and a factor for the matrices of implicit methods.
    pattern : (indptr, indices)
        Sparsity pattern of the lower triangle of the matrix, int32.
    mass_values : (n_values,) float
        The mass matrix on that pattern.
    q0, y0, dead_load, amplitudes : arrays
        All coordinates and the state at the start; the loads, which are constant.
    t : (k,) float
        Output times [s].
    method : str
        One of `METHODS`: Adams by fixed-point iteration, BDF by modified Newton, or an embedded
        Runge-Kutta formula of Dormand and Prince, Verner, or Fehlberg.
    rtol, atol : float
        Relative and absolute tolerance.
    cap : float
        Limit of wall time [s].

    Returns
    -------
    tuple
        States (k, 2 n_free), wall time [s], counts, and the reason of a failure: empty, ``"late"``
        or its name in SUNDIALS.
    """
    cdef Problem p
    cdef ptrdiff_t n, k
    cdef const int[::1] indptr = pattern[0], indices = pattern[1]
    p.system = <const ancf_system *>PyCapsule_GetPointer(system.capsule, "ancf_system")
    p.mass = <const ancf_seed *>PyCapsule_GetPointer(mass.capsule, "ancf_seed")
    p.iteration = <const ancf_seed *>PyCapsule_GetPointer(iteration.capsule, "ancf_seed")
    n = p.system.n_free
    cdef double[::1] q = np.array(q0), r = np.zeros(p.system.n_all + 64)
    # With an extra entry at the end, as the assembly of matrices requires.
    cdef double[:, ::1] values = np.zeros((3, p.system.n_values + 1))
    values[0, :p.system.n_values] = mass_values
    p.mass_values, p.stiffness_values, p.values = &values[0, 0], &values[1, 0], &values[2, 0]
    p.q, p.r = &q[0], &r[0]
    p.dead_load, p.amplitudes = &dead_load[0], &amplitudes[0]
    p.indptr, p.indices = &indptr[0], &indices[0]
    p.evaluations = p.jacobians = 0
    p.late = False
    cdef double[:, ::1] out = np.full((len(t), 2 * n), np.nan)
    cdef SUNContext context = NULL
    cdef SUNMatrix matrix = NULL
    cdef SUNLinearSolver linear = NULL
    cdef SUNNonlinearSolver fixed = NULL
    cdef void *memory = NULL
    cdef double reached = t[0], begin
    cdef long steps = 0
    cdef int flag = 0
    cdef bint runge_kutta = method in TABLES
    SUNContext_Create(NULL, &context)
    cdef N_Vector y = N_VNew_Serial(2 * n, context)
    memcpy(N_VGetArrayPointer_Serial(y), &y0[0], 2 * n * sizeof(double))
    try:
        begin = now()
        p.deadline = begin + cap
        if runge_kutta:
            memory = ERKStepCreate(rate, t[0], y, context)
            flag = (ERKStepSStolerances(memory, rtol, atol) or ERKStepSetUserData(memory, &p)
                    or ERKStepSetErrFile(memory, NULL)
                    or ERKStepSetMaxNumSteps(memory, MOST_STEPS)
                    or ERKStepSetTableNum(memory, TABLES[method]))
        else:
            memory = CVodeCreate(CV_ADAMS if method == "CVODE Adams" else CV_BDF, context)
            flag = (CVodeInit(memory, rate, t[0], y) or CVodeSStolerances(memory, rtol, atol)
                    or CVodeSetUserData(memory, &p) or CVodeSetErrFile(memory, NULL)
                    or CVodeSetMaxNumSteps(memory, MOST_STEPS))
            if method == "CVODE Adams":
                fixed = SUNNonlinSol_FixedPoint(y, 0, context)
                flag = flag or CVodeSetNonlinearSolver(memory, fixed)
            else:
                matrix, linear = SUNMatNewEmpty(context), SUNLinSolNewEmpty(context)
                matrix.ops.getid = matrix_id
                linear.content, linear.ops.gettype, linear.ops.solve = &p, solver_type, solve
                flag = (flag or CVodeSetLinearSolver(memory, linear, matrix)
                        or CVodeSetLinSysFn(memory, setup))
        if flag:
            raise RuntimeError(f"SUNDIALS rejected the settings of {method} (code {flag})")
        memcpy(&out[0, 0], &y0[0], 2 * n * sizeof(double))
        for k in range(1, t.shape[0]):
            if runge_kutta:
                flag = ERKStepEvolve(memory, t[k], y, &reached, ARK_NORMAL)
            else:
                flag = CVode(memory, t[k], y, &reached, CV_NORMAL)
            if flag < 0:
                break
            memcpy(&out[k, 0], N_VGetArrayPointer_Serial(y), 2 * n * sizeof(double))
        seconds = now() - begin
        if runge_kutta:
            ERKStepGetNumSteps(memory, &steps)
        else:
            CVodeGetNumSteps(memory, &steps)
        reason = "" if flag >= 0 else "late" if p.late else (
            ERKStepGetReturnFlagName(flag) if runge_kutta else CVodeGetReturnFlagName(flag)
        ).decode()
    finally:
        if runge_kutta:
            ERKStepFree(&memory)
        else:
            CVodeFree(&memory)
        if linear != NULL:
            SUNLinSolFreeEmpty(linear)
        if matrix != NULL:
            SUNMatFreeEmpty(matrix)
        if fixed != NULL:
            SUNNonlinSolFree(fixed)
        N_VDestroy_Serial(y)
        SUNContext_Free(&context)
    return np.asarray(out), seconds, p.evaluations, p.jacobians, steps, reason
