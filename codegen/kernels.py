"""The kernels of an element: what each is given, how many numbers it adds, what they are.

This is the only list of them.  Modules, enumeration and header follow from it; how a kernel is
derived is the method of its name in `derive.Derivation`.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Kernel:
    """One function of every generated module.

    Attributes
    ----------
    name : str
        Its name.
    inputs : tuple of str
        What the vectors q and a of the call hold, of those that it reads.
    shape : str
        ``"number"``, ``"vector"`` with one number per coordinate, or ``"triangle"``, the lower
        triangle of a symmetric matrix by rows.
    meaning : str
        What it adds.
    """

    name: str
    inputs: tuple[str, ...]
    shape: str
    meaning: str

    def size(self, n: int) -> int:
        """Return how many numbers it adds for an element of n coordinates."""
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
        "sum over strains of weight * (d strain/dq)(d strain/dq)^T: the tangent without stresses, "
        "and the derivative of damping by v",
    ),
    Kernel(
        "discrete_gradient",
        ("q0", "q1"),
        "vector",
        "force between two states: times q1 - q0 it is the difference of the energies",
    ),
)
"""In the order of the enumeration."""

NAMES = tuple(kernel.name for kernel in KERNELS)
