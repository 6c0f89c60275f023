"""Declarations of energy_watch.h; included by the time loops."""
include "../../abi/solver_abi.pxi"


cdef extern from "energy_watch.h":
    enum:
        WATCH_EVERY "ANCF_WATCH_EVERY"
    ctypedef struct ancf_watch:
        double limit, noise, rounding, errors, start, strain, potential, work, unsure, exchanged
        double gain, beyond, kinetic, most, seen, swing
        ptrdiff_t steps, due, when
    ctypedef struct ancf_jumps:
        ptrdiff_t n
        double first
        double *rate
        double *bend
        double *size
        double *past
        double *jump
        bint any
    void ancf_watch_start(ancf_watch *, const ancf_system *, const double *, const double *,
                          const double *, const double *, double *) noexcept nogil
    void ancf_watch_measure(ancf_watch *, const ancf_system *, const double *, const double *,
                            const double *, const double *, double *) noexcept nogil
    double ancf_watch_rounding(const ancf_watch *) noexcept nogil
    bint ancf_watch_gains(const ancf_watch *, bint) noexcept nogil
    bint ancf_watch_stops(const ancf_watch *) noexcept nogil
    bint ancf_watch_rises(const ancf_watch *, const ancf_watch *) noexcept nogil
    bint ancf_watch_gains_much(const ancf_watch *, bint) noexcept nogil
    double ancf_watch_motion(const ancf_watch *) noexcept nogil
    bint ancf_watch_gained(const ancf_watch *) noexcept nogil
    void ancf_watch_remember(ancf_watch *) noexcept nogil
    bint ancf_jumps_find(ancf_jumps *, const double *, const double *, double) noexcept nogil
    void ancf_jumps_accept(ancf_jumps *, const double *, const double *, double) noexcept nogil


cdef dict watch_memory(const ancf_watch *watch):
    """Return all values of a watch except its settings, by name, for continuing the run later."""
    cdef dict out = watch[0]
    del out["limit"], out["noise"], out["rounding"]
    return out


cdef recall_watch(ancf_watch *watch, dict memory):
    """Restore values that `watch_memory` returned; older files lack some."""
    settings = {"limit": watch.limit, "noise": watch.noise, "rounding": watch.rounding}
    errors = watch.rounding * (memory["steps"] + 1)
    watch[0] = settings | {"seen": memory["gain"], "swing": 0.0, "errors": errors} | memory
