"""Element kernels and the layout of their data.

`catalog` finds the kernels of an element by its name and options, `layout` packs elements into
vector lanes.  The calling convention of all kernels is `kernel_abi.h`; the modules themselves are
generated from `codegen/`.
"""
