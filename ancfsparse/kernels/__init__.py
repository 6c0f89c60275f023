"""Element kernels: which there are, how they are fed, and which build of them runs.

`catalog` turns the user's words into kernels, `layout` packs elements for them, `dispatch`
chooses the instruction set.  The convention all of them share is `kernel_abi.h`; the modules
themselves are generated from `codegen/`.
"""
