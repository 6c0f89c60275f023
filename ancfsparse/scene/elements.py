"""The elements a beam can be made of, as far as a scene must know them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from ancfsparse.errors import InputError, check_choice


class ElementFacts(NamedTuple):
    """What a beam needs to know about an element before it is built.

    ``dims`` are the dimensions of the scenes it works in; ``options`` holds the valid values of
    each of its options, the default first.
    """

    dims: tuple[int, ...]
    options: Mapping[str, tuple[str, ...]]


ELEMENTS: Mapping[str, ElementFacts] = {
    "l2t2": ElementFacts((2,), {}),
    "thin": ElementFacts((2, 3), {"strain": ("green", "biot")}),
    "thick": ElementFacts(
        (2, 3), {"curvature": ("axis", "section"), "section_strain": ("consistent", "nodal")}
    ),
}


def options_of(label: str, element: str, dim: int, said: Mapping[str, str]) -> dict[str, str]:
    """Pick the options an element has out of all that were said.

    Parameters
    ----------
    label : str
        Name of the beam, for messages.
    element : str
        Name of the element.
    dim : int
        Dimension of the scene.
    said : mapping of str to str
        A value for every option of every element.

    Returns
    -------
    dict of str to str
        The options of this element.

    Raises
    ------
    InputError
        If the element does not exist or not in this dimension, if a value is unknown, or if an
        option of another element was set to something else than its default.
    """
    check_choice("element", element, ELEMENTS)
    facts = ELEMENTS[element]
    if dim not in facts.dims:
        raise InputError(
            f"{element!r} is a planar element, but the scene of {label} is spatial: take 'thin', "
            "or make the scene planar with a gravity of 2 components"
        )
    every = {key: values for other in ELEMENTS.values() for key, values in other.options.items()}
    for key, value in said.items():
        check_choice(key, value, every[key])
        if key not in facts.options and value != every[key][0]:
            owner = next(each for each, other in ELEMENTS.items() if key in other.options)
            has = " and ".join(facts.options) or "none"
            raise InputError(
                f"{label} is made of {element!r}, which has no option {key} (its options: {has}): "
                f"leave {key}={value!r} out or take {owner!r}"
            )
    return {key: said[key] for key in facts.options}
