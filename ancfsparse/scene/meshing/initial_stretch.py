"""The initial shape of a beam, its length without stress, and its stretch."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_finite, check_moderate
from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import OPTIONS
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.scene.bodies.beam import BeamSpec
from ancfsparse.scene.geometry.catenary import Catenary
from ancfsparse.scene.geometry.curves import Line, Path
from ancfsparse.scene.geometry.positions import check_ends
from ancfsparse.scene.geometry.splines import path_of

MAX_STRETCH = 1e100  # [-], whose square is in the range of floating-point numbers
# Stretch below which Green's strain softens under compression [-].
MIN_GREEN_STRETCH = 3.0**-0.5


def initial_shape(
    record: BeamSpec, element: str, options: Mapping[str, str], gravity: Vector
) -> tuple[Path, float, float]:
    """Return the initial axis of a beam, its length without stress [m], and its stretch [-]."""
    label, dim = record.name, len(gravity)
    path: Path
    if record.curve is not None:
        for name in ("start", "end"):
            if getattr(record, name) is not None:
                raise InputError(
                    f"{label} has a curve and a {name}: leave `{name}` out, its ends are those of "
                    "the curve"
                )
        path = path_of(f"curve of {label}", record.curve, dim)
    else:
        start, end = check_ends(label, record.start, record.end, dim)
        path = Line(start, end)
    if record.tension is not None:
        if record.length is not None:
            raise InputError(f"{label} has a length and a tension: one follows from the other")
        force = check_finite(f"tension of {label}", record.tension, "N")
        if not record.section.is_uniform:
            raise InputError(
                f"the tension of {label} strains its sections differently, since they change along "
                "it: give the length instead"
            )
        stiffness = record.material.youngs_modulus * record.section.area
        stretch = _stretch_under_tension(label, element, options, force, stiffness)
        return path, path.length / stretch, stretch
    if record.length is None:
        return path, path.length, 1.0
    natural = check_moderate(f"length of {label}", record.length, "m")
    if record.curve is None and natural > path.length * (1.0 + 1e-12):
        return Catenary(label, start, end, natural, gravity), natural, 1.0
    return path, natural, path.length / natural


def _stretch_under_tension(
    label: str, element: str, options: Mapping[str, str], force: float, stiffness: float
) -> float:
    """Return the stretch l under a force: N = EA (l - 1), or EA l (l^2 - 1) / 2 (Green strain)."""
    if element not in OPTIONS:
        raise InputError(
            f"the tension of {label} cannot be turned into a length, since element {element} has a "
            "user-defined law: give the length instead"
        )
    strain = force / stiffness
    if options.get("strain") == "biot" or element == "string":
        smallest, stretch = -1.0, 1.0 + strain
    else:
        smallest = 0.5 * MIN_GREEN_STRETCH * (MIN_GREEN_STRETCH**2 - 1.0)
        stretch = 1.0 + max(strain, 0.0) ** (1.0 / 3.0) * 1.3
        for _ in range(100):
            change = (0.5 * stretch * (stretch**2 - 1.0) - strain) / (1.5 * stretch**2 - 0.5)
            stretch -= change
            if abs(change) <= 4e-16 * stretch or strain <= smallest:
                break
    if strain <= smallest:
        raise InputError(
            f"tension of {label} is {force:.6g} N, a compression without equilibrium: it must be "
            f"above {smallest * stiffness:.6g} N"
        )
    return stretch


def lateral_contraction(label: str, stretch: float, nu: float, kind: ElementKind) -> float:
    """Return the lateral stretch of a section that is free of lateral stress [-]."""
    square = 1.0 - nu * (stretch**2 - 1.0) if stretch < MAX_STRETCH else -math.inf
    if not 1.0 / MAX_STRETCH < stretch < MAX_STRETCH or (square <= 0.0 and not kind.is_cable):
        raise InputError(
            f"{label} would be stretched to {stretch:.6g} times its length, beyond the range of "
            "its element: check the units of `length` or `tension`"
        )
    return math.sqrt(max(square, 0.0))
