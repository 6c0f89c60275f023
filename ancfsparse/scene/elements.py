"""Which options of its element a beam takes, out of all that can be said."""

from __future__ import annotations

from collections.abc import Mapping

from ancfsparse.errors import InputError, check_choice
from ancfsparse.kernels.catalog import OPTIONS, PLANAR


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
    check_choice("element", element, OPTIONS)
    own = OPTIONS[element]
    if element in PLANAR and dim != 2:
        raise InputError(
            f"{element!r} is a planar element, but the scene of {label} is spatial: take 'thin', "
            "or make the scene planar with a gravity of 2 components"
        )
    every = {key: values for other in OPTIONS.values() for key, values in other.items()}
    for key, value in said.items():
        check_choice(key, value, every[key])
        if key not in own and value != every[key][0]:
            owner = next(each for each, other in OPTIONS.items() if key in other)
            has = " and ".join(own) or "none"
            raise InputError(
                f"{label} is made of {element!r}, which has no option {key} (its options: {has}): "
                f"leave {key}={value!r} out or take {owner!r}"
            )
    return {key: said[key] for key in own}
