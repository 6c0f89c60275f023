"""From the arguments of a beam along a curve, or of another length, to a checked `Beam`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import check_choice, check_count, check_finite, check_moderate, check_reals
from ancfsparse.errors import InputError, MessageTemplate, Parameter
from ancfsparse.kernels.catalog import CURVED, OPTIONS, ElementKind, curved_form
from ancfsparse.messages import format_value
from ancfsparse.scene.bodies.beam import Beam
from ancfsparse.scene.bodies.body import VelocityField
from ancfsparse.scene.bodies.element_choice import check_make, chosen_element
from ancfsparse.scene.meshing.straight_beam import (
    FARTHEST,
    along_principal_axes,
    check_ends,
    place,
    straight_beam,
    velocity_field,
)
from ancfsparse.scene.sections.material import Material
from ancfsparse.scene.sections.sections import AnySection, Taper
from ancfsparse.system_memory import check_memory

if TYPE_CHECKING:
    from ancfsparse.scene.geometry.curves import Angle, Direction, Path
    from ancfsparse.scene.geometry.splines import AnyCurve

Vector = NDArray[np.float64]

RESTS = ("curved", "straight")
"""Shapes in which a beam along a curve may be free of stress, the default first."""

# Stretches [-] up to this have squares that are numbers.
LARGEST = 1e100
# Stretch [-] below which Green's strain softens under compression: 1 / sqrt(3).
WEAKEST = 3.0**-0.5


@dataclass(frozen=True)
class Shape:
    """The arguments that describe how a beam lies, and how it is strained there.

    Attributes
    ----------
    start, end, curve, rest, length, tension, up, twist, nodes
        As in `Scene.add_beam`.
    """

    start: ArrayLike | None
    end: ArrayLike | None
    curve: AnyCurve | None = None
    rest: str = RESTS[0]
    length: float | None = None
    tension: float | None = None
    up: Direction = None
    twist: Angle = None
    nodes: ArrayLike | None = None

    @property
    def is_plain(self) -> bool:
        """Whether it is straight, not twisted, and free of stress."""
        given = self.curve, self.length, self.tension, self.twist, self.nodes
        return all(each is None for each in given)


def beam_of(
    label: str,
    gravity: Vector,
    element: str | ElementKind,
    shape: Shape,
    n_elements: int | str | None,
    section: AnySection | None,
    material: Material | None,
    options: Mapping[str, str],
    velocity: ArrayLike | VelocityField | None,
) -> Beam:
    """Check the arguments of a beam and make its handle.

    Parameters
    ----------
    label : str
        Its name.
    gravity : ndarray, shape (dim,)
        Of the scene [m/s2].
    element, n_elements, section, material, velocity
        As in `Scene.add_beam`.
    shape : Shape
        Where it is.
    options : mapping of str to str
        A value for every option of every element.

    Returns
    -------
    Beam
        The handle, not yet part of a scene.
    """
    shares = None
    if shape.nodes is not None:
        shares = _shares(label, shape.nodes, n_elements)
        n_elements = len(shares) - 1
    if n_elements is None or section is None or material is None:
        needed = {"n_elements": n_elements, "section": section, "material": material}
        missing = next(what for what, given in needed.items() if given is None)
        raise InputError(f"{label} needs `{missing}`: give it to add_beam")
    if shape.is_plain and not callable(shape.up) and not isinstance(section, Taper):
        return straight_beam(
            label, len(gravity), element, shape.start, shape.end, n_elements, section, material,
            options, shape.up, velocity,
        )  # fmt: skip
    return _shaped(
        label, gravity, element, shape, shares, n_elements, section, material, options, velocity
    )


def _shares(label: str, nodes: ArrayLike, n_elements: int | str | None) -> Vector:
    """Return the shares of the length at which nodes stand, (n + 1,)."""
    needed = "shares of its length that grow from 0 to 1, such as (0, 0.1, 0.3, 1)"
    shares = check_reals(f"nodes of {label}", nodes, needed)
    if (
        shares.ndim != 1
        or len(shares) < 2
        or (shares[0], shares[-1]) != (0.0, 1.0)
        or not (np.diff(shares) > 0.0).all()
    ):
        raise InputError(f"nodes of {label} must be {needed}, got {format_value(nodes)}")
    if n_elements is not None and n_elements != len(shares) - 1:
        raise InputError(
            f"{label} has {len(shares)} nodes, which make {len(shares) - 1} elements, but "
            f"n_elements is {format_value(n_elements)}: leave one of them out"
        )
    return shares


def _shaped(
    label: str,
    gravity: Vector,
    element: str | ElementKind,
    shape: Shape,
    shares: Vector | None,
    n_elements: int | str,
    section: AnySection,
    material: Material,
    options: Mapping[str, str],
    velocity: ArrayLike | VelocityField | None,
) -> Beam:
    """Check the arguments of a beam that is not even all along."""
    from ancfsparse.scene.geometry.section_frames_along import frames_along

    dim = len(gravity)
    name, chosen, kind = chosen_element(label, element, dim, options)
    count = check_count(f"n_elements of {label}", n_elements)
    check_make(label, kind, section, material)
    fewer = MessageTemplate("a smaller {n_elements}", n_elements=Parameter("n_elements"))
    check_memory(f"{label}, {count} elements,", (64.0 * dim**2 + 400.0) * count, fewer)
    _check_directions(label, name, kind, shape)
    path, natural, stretch = _strained(label, gravity, name, chosen, section, material, shape)
    across = _narrowed(label, stretch, material.poisson_ratio, kind)
    if _rests_curved(label, shape) and not kind.is_string:
        kind = curved_kind(label, name, kind)
    even = np.arange(count + 1) / count if shares is None else shares
    s = even * path.length
    positions, tangents = path.at(s)
    if shape.curve is None:  # as they were given, without rounding
        positions[[0, -1]] = check_ends(label, shape.start, shape.end, dim)
    _check_range(label, positions)
    lengths = np.full(count, natural / count) if shares is None else np.diff(shares) * natural
    if kind.is_string and shape.curve is not None and shape.length is None:
        lengths = np.linalg.norm(np.diff(positions, axis=0), axis=1) / stretch
    arcs = np.concatenate([[0.0], np.cumsum(lengths)])
    arcs[-1] = arcs[-1] if kind.is_string else natural
    frames = frames_along(label, path, s, tangents, shape.up, shape.twist)
    frames = along_principal_axes(frames, section)
    vectors = stretch * frames
    if not kind.is_cable:
        vectors[:, 1:] = across * frames[:, 1:]
    rows = np.arange(count + 1, dtype=np.int32)
    ends = np.stack([rows[:-1], rows[1:]], axis=1)
    for array in (positions, frames, vectors, rows, ends, arcs, lengths):
        array.flags.writeable = False
    return Beam(
        name=label,
        element=name,
        options=chosen,
        kind=kind,
        section=section,
        material=material,
        positions=positions,
        n_each=count,
        lengths=lengths,
        row_nodes=rows,
        ends=ends,
        vectors=vectors,
        velocity=None if velocity is None else velocity_field(label, velocity, positions),
        arcs=arcs,
        frames=frames,
        nodes=None if shares is None else tuple(shares.tolist()),
    )


def _check_directions(label: str, name: str, kind: ElementKind, shape: Shape) -> None:
    """Refuse directions of the section where it has none to choose."""
    if kind.dim == 2:
        for each in ("up", "twist"):
            if getattr(shape, each) is not None:
                raise InputError(
                    f"`{each}` of {label} has no meaning in a planar scene, where the height of "
                    "the section lies in the plane: leave it out"
                )
    if (kind.is_cable or kind.is_string) and shape.twist is not None:
        raise InputError(
            f"{label} is made of {name!r}, which has no torsion and no section to twist: leave "
            "`twist` out or take 'thick'"
        )


def _rests_curved(label: str, shape: Shape) -> bool:
    """Whether the shape free of stress is not straight."""
    curved = check_choice(f"rest of {label}", shape.rest, RESTS) == "curved"
    if shape.curve is None and shape.twist is None and not callable(shape.up):
        return False
    if curved and (shape.length is not None or shape.tension is not None):
        what = "length" if shape.tension is None else "tension"
        raise InputError(
            f"{label} follows a curve in which it is free of stress, so `{what}` contradicts it: "
            "leave that out, or give rest='straight'"
        )
    return curved


def curved_kind(label: str, name: str, kind: ElementKind) -> ElementKind:
    """Return the form of an element that is free of strain in a curved shape."""
    if kind.is_curved:
        return kind
    if kind.package:
        raise InputError(
            f"element {name} of {label} is free of strain where it is straight: define it with "
            "curved=True, or give rest='straight'"
        )
    if kind.dim not in CURVED.get(name, ()):
        why = (
            "has no torsion, so its curvature has no direction in the section that it could return "
            "to"
            if kind.dim == 3
            else "measures bending by r'', which has no reference"
        )
        other = "'thick'" if kind.dim == 3 else "'thin'"
        raise InputError(
            f"{label} cannot be free of stress along a curve: element {name!r} {why}; take "
            f"{other}, or rest='straight' for one that is bent into the curve"
        )
    return curved_form(kind)


def _strained(
    label: str,
    gravity: Vector,
    element: str,
    options: Mapping[str, str],
    section: AnySection,
    material: Material,
    shape: Shape,
) -> tuple[Path, float, float]:
    """Return where a beam lies, its length without stress [m], and its stretch there [-]."""
    from ancfsparse.scene.geometry.catenary import Catenary
    from ancfsparse.scene.geometry.curves import Line
    from ancfsparse.scene.geometry.splines import path_of

    dim = len(gravity)
    path: Path
    if shape.curve is not None:
        for name in ("start", "end"):
            if getattr(shape, name) is not None:
                raise InputError(
                    f"{label} has a curve and a {name}: leave `{name}` out, its ends are those of "
                    "the curve"
                )
        path = path_of(f"curve of {label}", shape.curve, dim)
    else:
        start, end = check_ends(label, shape.start, shape.end, dim)
        path = Line(start, end)
    if shape.tension is not None:
        if shape.length is not None:
            raise InputError(f"{label} has a length and a tension: one follows from the other")
        force = check_finite(f"tension of {label}", shape.tension, "N")
        if isinstance(section, Taper):
            raise InputError(
                f"the tension of {label} strains its sections differently, since they change along "
                "it: give the length instead"
            )
        stiffness = material.youngs_modulus * section.area
        stretch = _stretched(label, element, options, force, stiffness)
        return path, path.length / stretch, stretch
    if shape.length is None:
        return path, path.length, 1.0
    natural = check_moderate(f"length of {label}", shape.length, "m")
    if shape.curve is None and natural > path.length * (1.0 + 1e-12):
        return Catenary(label, start, end, natural, gravity), natural, 1.0
    return path, natural, path.length / natural


def _stretched(
    label: str, element: str, options: Mapping[str, str], force: float, stiffness: float
) -> float:
    """Return the stretch under a force: N = EA (l - 1), or EA l (l^2 - 1) / 2 by Green's strain."""
    if element not in OPTIONS:
        raise InputError(
            f"the tension of {label} cannot be turned into a length, since element {element} has a "
            "law of its own: give the length instead"
        )
    share = force / stiffness
    if options.get("strain") == "biot" or element == "string":
        least, stretch = -1.0, 1.0 + share
    else:
        least = 0.5 * WEAKEST * (WEAKEST**2 - 1.0)
        stretch = 1.0 + max(share, 0.0) ** (1.0 / 3.0) * 1.3
        for _ in range(100):
            change = (0.5 * stretch * (stretch**2 - 1.0) - share) / (1.5 * stretch**2 - 0.5)
            stretch -= change
            if abs(change) <= 4e-16 * stretch or share <= least:
                break
    if share <= least:
        raise InputError(
            f"tension of {label} is {force:.6g} N, a compression that its axis does not bear: it "
            f"must be above {least * stiffness:.6g} N"
        )
    return stretch


def _narrowed(label: str, stretch: float, nu: float, kind: ElementKind) -> float:
    """Return by what a section is smaller where it is free of stress across the stretched axis."""
    square = 1.0 - nu * (stretch**2 - 1.0) if stretch < LARGEST else -math.inf
    if not 1.0 / LARGEST < stretch < LARGEST or (square <= 0.0 and not kind.is_cable):
        raise InputError(
            f"{label} would be stretched to {stretch:.6g} times its length, which its element does "
            "not bear: check the units of `length` or `tension`"
        )
    return math.sqrt(max(square, 0.0))


def _check_range(label: str, positions: Vector) -> None:
    """Refuse positions whose squares leave the range of numbers."""
    if not np.abs(positions).max() <= FARTHEST:
        raise InputError(
            f"{label} reaches beyond {FARTHEST:g} m, to "
            f"{place(positions[np.argmax(np.abs(positions).max(axis=1))])}; give positions in "
            "metres"
        )
