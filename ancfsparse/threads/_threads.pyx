# cython: language_level=3
"""The threads that all compiled modules share, see teams.h."""
from cpython.pycapsule cimport PyCapsule_New

cdef extern from "teams.h":
    int teams_prepare()
    void team_run()

if not teams_prepare():
    raise MemoryError("no memory for threads")
run = PyCapsule_New(<void *>team_run, "ancfsparse.compiled.threads.run", NULL)  # for parallel.h
