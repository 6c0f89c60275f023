"""The kernels of an element: their inputs, the size and the meaning of their results.

This is the only list of them, from which modules, enumeration and header are generated; the method
of the same name in `derive.Derivation` derives the kernel.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Kernel:
    """A function of all generated modules.

    Attributes
    ----------
    name : str
        Its name.
    inputs : tuple of str
        Contents of the arguments q and a, as far as it reads them.
    shape : str
        ``"number"``, ``"vector"`` with one number per coordinate, or ``"triangle"``, the lower
        triangle of a symmetric matrix by rows.
    meaning : str
        The result, which is added to the output.
    """

    name: str
    inputs: tuple[str, ...]
    shape: str
    meaning: str

    def size(self, n: int) -> int:
        """Return the size of the result for an element of n coordinates."""
        return {"number": 1, "vector": n, "triangle": n * (n + 1) // 2}[self.shape]


KERNELS = (
    Kernel("energy", ("q",), "number", "strain energy"),
    Kernel("force", ("q",), "vector", "elastic force Q(q)"),
    Kernel("inertia", ("a",), "vector", "M a"),
    Kernel("residual", ("q", "a"), "vector", "Q(q) + M a"),
    Kernel("tangent", ("q",), "triangle", "dQ/dq"),
    Kernel("mass", (), "triangle", "M"),
    Kernel(
        "damping", ("q", "v"), "vector", "sum over strains of weight * d strain/dt * d strain/dq"
    ),
    Kernel(
        "material",
        ("q",),
        "triangle",
        "sum over strains of weight * (d strain/dq)(d strain/dq)^T: the tangent without geometric "
        "stiffness, and the derivative of the damping force by v",
    ),
    Kernel(
        "discrete_gradient",
        ("q0", "q1"),
        "vector",
        "force between two states, whose product with q1 - q0 is the difference of energies",
    ),
)
"""In the order of the enumeration."""

NAMES = tuple(kernel.name for kernel in KERNELS)
