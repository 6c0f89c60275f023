"""The element of a beam, and its options.

In all functions `label` is the name of the beam in messages, `dim` the dimension of the scene,
`element` the argument of `Scene.add_beam`, and `given` has a value for every option of every
element, None for its default.  An `InputError` for an invalid argument suggests a valid one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ancfsparse.checks import check_choice, check_positive
from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import (
    CURVED,
    OPTIONS,
    PLANAR,
    curved_form,
    element_kind,
    slack_form,
)
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.messages import format_value
from ancfsparse.scene.records.record import Record
from ancfsparse.scene.sections.cross_section import (
    AnySection,
    list_section_types,
    principal_axes,
)
from ancfsparse.scene.sections.material import Material

MAX_INERTIA_DIFFERENCE = 1e-9  # of the second moments of a round section, over the larger
MIN_SLACK_STRAIN = 1e-9  # of strings, large compared with the rounding error of a strain, 1e-16
# Values of all options of all elements, their defaults first.
VALUES = {key: values for own in OPTIONS.values() for key, values in own.items()}


def given_options(record: Record) -> dict[str, str | None]:
    """Return the value that a record has for every option of every element."""
    return {name: getattr(record, name) for name in VALUES}


def left_out(record: Record) -> dict[str, Any]:
    """Return None for every option that a record has at its default, so that records compare."""
    given = given_options(record)
    return {name: None for name, values in VALUES.items() if given[name] == values[0]}


def chosen_element(
    label: str, element: str | ElementKind, dim: int, given: Mapping[str, str | None]
) -> tuple[str, dict[str, str], ElementKind]:
    """Return the name of an element in messages, its options, and its type."""
    if not isinstance(element, ElementKind):
        options = options_of(label, element, dim, given)
        return element, options, element_kind(element, dim, **options)
    if element.dim != dim:
        has = {2: "planar", 3: "spatial"}
        raise InputError(
            f"element {element.name} is {has[element.dim]}, but the scene of {label} is "
            f"{has[dim]}: give the scene a gravity with {element.dim} components"
        )
    for key, value in given.items():
        if value is not None:
            raise InputError(
                f"element {element.name} of {label} has no options: leave "
                f"{key}={format_value(value)} out"
            )
    missing = [name for name in element.own if name not in element.values]
    if missing:
        raise InputError(
            f"element {element.name} of {label} needs a value of its own parameter {missing[0]}: "
            f"give ELEMENT.with_values({missing[0]}=...)"
        )
    return element.name, {}, element


def slack_string(label: str, element: str | ElementKind, dim: int, slack: float) -> ElementKind:
    """Return the string element that goes slack about a strain between 0 and 1."""
    if not isinstance(element, str) or element != "string":
        raise InputError(
            f"slack of {label} applies to strings only, not to {format_value(element)}: take "
            "'string', or leave `slack` out"
        )
    strain = check_positive(f"slack of {label}", slack)
    # At 1 the transition begins at length zero; below the minimum its square is lost by rounding.
    if not MIN_SLACK_STRAIN <= strain < 1.0:
        raise InputError(
            f"slack of {label} is a strain from {MIN_SLACK_STRAIN:g} to 1, got {strain:.6g}: take "
            "about the strain under the smallest force of interest"
        )
    return slack_form(dim, strain)


def options_of(
    label: str, element: str, dim: int, given: Mapping[str, str | None]
) -> dict[str, str]:
    """Return the options of an element out of the values for all elements."""
    check_choice("element", element, OPTIONS)
    own = OPTIONS[element]
    if element in PLANAR and dim != 2:
        raise InputError(
            f"{element!r} is a planar element, but the scene of {label} is spatial: take 'thin', "
            "or make the scene planar with a gravity of 2 components"
        )
    for key, value in given.items():
        if value is None:
            continue
        check_choice(key, value, VALUES[key])
        if key not in own:
            owner = next(name for name, other in OPTIONS.items() if key in other)
            has = " and ".join(own) or "none"
            raise InputError(
                f"{label} is made of {element!r}, which has no option {key} (its options: {has}): "
                f"leave {key}={value!r} out or take {owner!r}"
            )
    return {key: given[key] or values[0] for key, values in own.items()}


def check_make(label: str, kind: ElementKind, section: AnySection, material: Material) -> None:
    """Check section and material, and refuse a spatial cable whose section is not round."""
    if not isinstance(section, AnySection):
        raise InputError(
            f"section of {label} must be a {list_section_types()}, got {format_value(section)}: "
            "try ancf.Rectangle(0.01, 0.01)"
        )
    if not isinstance(material, Material):
        raise InputError(
            f"material of {label} must be a Material, got {format_value(material)}: "
            "try ancf.Material(youngs_modulus=1e8, density=4000)"
        )
    for part in section.parts:
        angle, about_y, about_z = principal_axes(part)
        if angle and kind.dim == 2:
            raise InputError(
                f"section of {label} has an inertia_yz, so bending leaves the plane: "
                "take a spatial scene"
            )
        is_round = abs(about_y - about_z) <= MAX_INERTIA_DIFFERENCE * max(about_y, about_z)
        if kind.bends_alike and not is_round:
            raise InputError(
                f"{label} is a spatial cable, whose bending stiffness is the same in all "
                f"directions, but its section has inertia_y = {about_y:.6g} m4 and inertia_z = "
                f"{about_z:.6g} m4: make them equal, or take the element 'thick'"
            )
        if angle and not section.is_uniform:
            raise InputError(
                f"section of {label} is a {type(section).__name__} of a section with inertia_yz, "
                "whose principal axes could rotate along the beam: take Polygon.principal() and "
                "`up`"
            )


def refuse_in_plane(label: str, argument: str) -> None:
    """Refuse a direction of the section in a planar scene."""
    raise InputError(
        f"`{argument}` of {label} has no meaning in a planar scene, where the height of the "
        "section lies in the plane: leave it out"
    )


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
            "has no torsion, so its curvature has no direction in the section"
            if kind.dim == 3
            else "measures bending by r'', which has no reference"
        )
        other = "'thick'" if kind.dim == 3 else "'thin'"
        raise InputError(
            f"{label} cannot be free of stress along a curve: element {name!r} {why}; take "
            f"{other}, or rest='straight' for one that is bent into the curve"
        )
    return curved_form(kind)
