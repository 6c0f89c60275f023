"""Calls of kernels on a handful of elements."""

import numpy as np

from ancfsparse.dispatch import compiled_module
from ancfsparse.kernels.element_kind import from_module
from ancfsparse.kernels.layout import pack

VALUES = {
    "length": 0.7,
    "axial_stiffness": 1e3,
    "bending_stiffness": 3.0,
    "mass_per_length": 2.0,
    "lame_area": 500.0,
    "shear_modulus_area": 400.0,
    "youngs_modulus_area": 1100.0,
    "poisson_ratio": 0.28,
    "shear_stiffness_y": 330.0,
    "shear_stiffness_z": 350.0,
    "torsion_stiffness": 2.0,
    "bending_stiffness_y": 3.0,
    "bending_stiffness_z": 2.5,
    "inertia_y": 0.01,
    "inertia_z": 0.02,
    "transition": 0.2,
}
"""One value for every parameter in the vocabulary, none of them special."""


class Bench:
    """Calls the kernels of one module on elements that share nothing."""

    def __init__(self, name, instruction_set=None):
        self.kind = from_module(compiled_module(name, instruction_set))
        self.call = compiled_module("kernel_call", instruction_set).call
        self.n = self.kind.n_coordinates
        self.labels = self.kind.node_coordinates

    def run(self, kernel, q_e, a_e=None, base=None):
        """Return what the kernel adds for each row of q_e, (n_elements, n_out)."""
        q_e = np.atleast_2d(np.asarray(q_e, dtype=np.float64))
        a_e = q_e if a_e is None else np.atleast_2d(a_e)
        n_e, n_out = len(q_e), self.kind.n_out(kernel)
        if base is None:
            base = np.tile([VALUES[p] for p in self.kind.parameters], (n_e, 1))
        out = np.zeros((n_e, n_out))
        layout = pack(
            self.kind,
            np.arange(n_e * self.n).reshape(n_e, self.n),
            np.arange(n_e * n_out).reshape(n_e, n_out),
            base,
        )
        self.call(
            self.kind.kernels[kernel], layout.gather, layout.scatter, layout.set_of,
            layout.parameters, np.ascontiguousarray(q_e).ravel(), np.ascontiguousarray(a_e).ravel(),
            out.ravel(),
        )  # fmt: skip
        return out

    def matrix(self, kernel, q_e, **options):
        """Return full symmetric matrices, (n_elements, n, n)."""
        rows = self.run(kernel, q_e, **options)
        result = np.zeros((len(rows), self.n, self.n))
        i, j = np.tril_indices(self.n)
        result[:, i, j] = rows
        result[:, j, i] = rows
        return result
