"""Rotations of the nodes of a body, as Python sees them; the structure is in solver_abi.h."""

from typing import Protocol


class Frame(Protocol):
    """Compiled rotations of the nodes of a system (_rotation.pyx)."""

    @property
    def capsule(self) -> object:
        """What inverses call, "ancf_frame"."""

    @property
    def operations(self) -> int:
        """Operations of turning a vector there and back."""
