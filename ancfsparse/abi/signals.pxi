"""Checks for signals, such as an interrupt, between steps; included by the time loops."""
include "clock.pxi"

cdef extern from "Python.h":
    int PyErr_CheckSignals() except -1


# Coordinate updates between two readings of the clock (20 ns each), and the time between two checks
# for signals, which need the interpreter lock [s].
cdef ptrdiff_t MOVED = 20000
cdef double PATIENCE = 0.05


cdef struct Signals:
    ptrdiff_t moved
    double asked


cdef inline bint due(Signals *self, ptrdiff_t n) noexcept nogil:
    """Return True if signals are due to be checked, after another step of n coordinates."""
    cdef double time
    self.moved += n
    if self.moved < MOVED:
        return False
    self.moved = 0
    time = now()
    if time - self.asked < PATIENCE:
        return False
    self.asked = time
    return True
