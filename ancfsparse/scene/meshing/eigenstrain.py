"""Eigenstrains: by temperature, swelling, or layers of different materials."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.checks import call_function, check_finite, check_reals
from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import CURVED
from ancfsparse.messages import format_value
from ancfsparse.scene.bodies.beam import Beam
from ancfsparse.scene.bodies.element_choice import curved_kind
from ancfsparse.scene.records.signal import Signal

Eigenstrain = float | Signal | Callable[[float], float] | None
Eigencurvature = ArrayLike | Signal | Callable[[float], ArrayLike] | None


def with_eigenstrain(beam: Beam, strain: Eigenstrain, curvature: Eigencurvature) -> Beam:
    """Return a beam that is stress-free with axial strains [-] and curvatures [1/m]."""
    if strain is None and curvature is None:
        return beam
    width = 1 if beam.dim == 2 else 2
    changing = _signals(beam, strain, curvature)
    strain = None if isinstance(strain, Signal) else strain
    curvature = None if isinstance(curvature, Signal) else curvature
    values = np.zeros((beam.n_elements, 1 + width))
    middles = beam.arcs[:-1] + 0.5 * beam.lengths
    for k, s in enumerate(middles.tolist()):
        what = f"eigenstrain of {beam.name}"
        values[k, 0] = check_finite(what, _at(what, strain, s))
        what = f"eigencurvature of {beam.name}"
        kappa = _at(what, curvature, s)
        if curvature is None:
            continue
        if beam.dim == 2:
            values[k, 1] = check_finite(what, kappa, "1/m")
            continue
        pair = check_reals(what, kappa, "two numbers, about e_y and e_z")
        if pair.shape != (2,) or not np.isfinite(pair).all():
            raise InputError(
                f"{what} must be two finite numbers in 1/m, about e_y and e_z, got "
                f"{format_value(kappa)}"
            )
        values[k, 1:] = pair
    if not values[:, 0].min() > -1.0:
        raise InputError(
            f"eigenstrain of {beam.name} is {values[:, 0].min():g}: it must be above -1, at "
            "which the length is zero"
        )
    if not beam.kind.package and beam.dim not in CURVED.get(beam.element, ()):
        raise InputError(
            f"{beam.name} is made of {beam.element!r}, which is free of strain where it is "
            "straight: take 'thick', or 'thin' in the plane; an eigenstrain e of the axis alone is "
            "a `length` of (1 + e) times the distance"
        )
    kind = curved_kind(beam.name, beam.element, beam.kind)
    return replace(beam, kind=kind, eigen=values, changing=changing)


def _signals(
    beam: Beam, strain: Eigenstrain, curvature: Eigencurvature
) -> tuple[Signal | None, Signal | None] | None:
    """Return the signals of the eigenstrain and eigencurvature, or None without signals."""
    strain_signal = strain if isinstance(strain, Signal) else None
    curvature_signal = curvature if isinstance(curvature, Signal) else None
    shape = () if beam.dim == 2 else (2,)
    for name, signal, needed in (
        ("eigenstrain", strain_signal, ()),
        ("eigencurvature", curvature_signal, shape),
    ):
        if signal is not None and np.shape(signal(0.0)) != needed:
            what = "a number" if needed == () else "two numbers, about e_y and e_z"
            raise InputError(f"{name} of {beam.name} must be a signal of {what}, got {signal!r}")
    return (
        None
        if strain_signal is None and curvature_signal is None
        else (strain_signal, curvature_signal)
    )


def _at(what: str, value: object, s: float) -> object:
    """Return a value, or the value of a function at an arc coordinate s [m]."""
    if value is None:
        return 0.0
    if not callable(value):
        return value
    return call_function(what, value, s, f"at s = {s:.6g} m")
