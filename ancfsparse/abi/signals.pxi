"""The clock, and checks for signals, such as an interrupt, between steps; an include file."""
cdef extern from "<time.h>":
    ctypedef long time_t
    cdef struct timespec:
        time_t tv_sec
        long tv_nsec
    int clock_gettime(int, timespec *) noexcept nogil
    int CLOCK_MONOTONIC

cdef extern from "Python.h":
    int PyErr_CheckSignals() except -1


# Coordinate updates between two readings of the clock (20 ns each), and the time between two checks
# for signals, which need the interpreter lock [s].
cdef ptrdiff_t MOVED = 20000
cdef double PATIENCE = 0.05


cdef struct Signals:
    ptrdiff_t moved
    double asked


cdef inline double now() noexcept nogil:
    cdef timespec t
    clock_gettime(CLOCK_MONOTONIC, &t)
    return t.tv_sec + 1e-9 * t.tv_nsec


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
