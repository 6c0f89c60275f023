"""Element kernels: which there are (`catalog`), how they are fed (`layout`), which build runs (`dispatch`).

The convention all of them share is `kernel_abi.h`; the modules themselves are generated from `codegen/`.
"""
