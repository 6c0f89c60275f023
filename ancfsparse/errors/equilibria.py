"""Errors and warnings of statics and of modes."""

from __future__ import annotations

from dataclasses import dataclass

from ancfsparse.errors.inputs import AncfError
from ancfsparse.errors.message import MessageStyle, format_quantity, python_style


@dataclass(eq=False, repr=False)
class EquilibriumError(AncfError, RuntimeError):
    """No static equilibrium was found.

    Parameters
    ----------
    reason : str
        Description of the failure (sentence or clause).
    load_fraction : float
        Fraction of the full load, in (0, 1], at which the iteration failed.
    residual : float
        Largest entry of the residual [N or N m].
    where : str
        Beam, node and coordinate of that entry.
    unit : str, optional
        Unit of the residual.
    advice : str, optional
        Advice.
    """

    reason: str
    load_fraction: float
    residual: float
    where: str
    unit: str = ""
    # More load steps have no use: failed ones are halved, and plans and motions take none.
    advice: str = "Check joints and loads, try smaller loads, or take a finer mesh."

    def message(self, style: MessageStyle = python_style) -> str:
        """Return the message in a style."""
        return (
            f"no equilibrium at {100 * self.load_fraction:.4g} % of the load: "
            f"{self.reason.rstrip('.')}. "
            f"The largest residual is {format_quantity(self.residual, self.unit, 3)} at "
            f"{self.where}. " + self.advice
        )


@dataclass(eq=False, repr=False)
class AssemblyError(AncfError, RuntimeError):
    """Joints and drives cannot be satisfied together.

    Parameters
    ----------
    where : str
        The joint with the largest violation.
    violation : float
        Its violation [m].
    before : float
        Largest violation in the reference shape [m].
    """

    where: str
    violation: float
    before: float

    def message(self, style: MessageStyle = python_style) -> str:
        """Return the message in a style."""
        return (
            f"the scene cannot be assembled: the {self.where} stays violated by "
            f"{self.violation:.3g} m, of {self.before:.3g} m at first. Check that the lengths "
            "allow all joints and drives at once, or place the bodies closer to their assembled "
            "positions"
        )


class UnstableEquilibriumWarning(UserWarning):
    """The computed static equilibrium is unstable: small perturbations grow.

    Parameters
    ----------
    negative : int
        Number of independent unstable directions: negative pivots, and so negative eigenvalues, of
        the stiffness.
    """

    def __init__(self, negative: int) -> None:
        super().__init__(negative)
        self.negative = negative

    def __str__(self) -> str:
        """Return the message."""
        return (
            f"the equilibrium is unstable in {self.negative} "
            f"direction{'s' * (self.negative > 1)}, as a straight column is beyond its buckling "
            "load: add a small force or a bend that selects a direction of buckling, or compute "
            "the motion to a stable state with simulate; modes(equilibrium, 1) gives the unstable "
            "shape"
        )


@dataclass(eq=False, repr=False)
class ModesError(AncfError, RuntimeError):
    """Natural frequencies were not found to working accuracy.

    Parameters
    ----------
    reason : str
        Description of the failure.
    """

    reason: str

    def message(self, style: MessageStyle = python_style) -> str:
        """Return the message in a style."""
        return (
            f"the modes were not found: {self.reason}. Request a few more or fewer, and check that "
            "no part of the scene is some 1e12 times as stiff as the others"
        )


class ApproximateModesWarning(UserWarning):
    """Some forces have no potential; modes use only the symmetric part of their stiffness."""

    def __str__(self) -> str:
        """Return the message."""
        return (
            "some forces have no potential, such as functions of the motion and moments about "
            "fixed axes in space; modes use only the symmetric part of their stiffness, so "
            "frequencies may be inaccurate and flutter is not detected: take complex_modes"
        )
