"""The watch of energy_watch.h; text for the time loops."""
include "solver_abi.pxi"


cdef extern from "energy_watch.h":
    ctypedef struct ancf_watch:
        double limit, noise, work, exchanged, gain, kinetic
    void ancf_watch_start(ancf_watch *, const ancf_system *, const double *, const double *,
                          const double *, double *) noexcept nogil
    bint ancf_watch_gains(ancf_watch *, const ancf_system *, const double *, const double *,
                          const double *, double *, bint) noexcept nogil
