"""Python interface of the rotations of nodes; the structure is in solver_abi.h."""

from typing import Protocol


class Frame(Protocol):
    """Compiled rotations of the nodes of a system (_rotation.pyx)."""

    @property
    def capsule(self) -> object:
        """Structure "ancf_frame" for inverses."""

    @property
    def operations(self) -> int:
        """Operations of rotating a vector forwards and backwards."""
