"""Element kernels: which there are, and how they are fed.

`catalog` turns the user's words into kernels, `layout` packs elements for them.  The convention all
of them share is `kernel_abi.h`; the modules themselves are generated from `codegen/`.
"""
