"""Catalog of elements by name, and of their modules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product

from ancfsparse.checks import check_choice
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import InputError
from ancfsparse.kernels.element_kind import RIGID, ElementKind, from_module

OPTIONS: dict[str, dict[str, tuple[str, ...]]] = {
    "string": {},
    "l2t2": {},
    "thin": {"strain": ("green", "biot")},
    "thick": {"curvature": ("axis", "section"), "section_strain": ("consistent", "nodal")},
}
"""Elements, their options, and the values of each; the first value is the default."""

MODULES: dict[str, dict[int, str]] = {
    "string": {2: "string_planar", 3: "string_spatial"},
    "l2t2": {2: "l2t2"},
    "thin": {2: "thin_planar_{strain}", 3: "thin_spatial_{strain}"},
    "thick": {
        3: "thick_{curvature}_{section_strain}",
        2: "thick_planar_{curvature}_{section_strain}",
    },
}
"""Names of the modules of every element by dimension, with options as placeholders."""

ORDERS = {"string": 2, "l2t2": 4, "thin": 4, "thick": 2, RIGID: 8}
"""Orders of convergence of positions in the length of the elements (docs/accuracy.md).

A rigid rod has no mesh, so its order limits no other.
"""


@dataclass(frozen=True)
class ElementChoice:
    """Element with its options.

    Attributes
    ----------
    name : str
        As `Scene.add_beam` takes it.
    options : mapping of str to str
        Options that differ from their defaults.
    neglects : frozenset of str
        Effects that its energies lack.
    """

    name: str
    options: Mapping[str, str] = field(default_factory=dict)
    neglects: frozenset[str] = field(default=frozenset(), compare=False)

    @property
    def order(self) -> int:
        """Order of convergence of positions in the length of the elements."""
        return ORDERS[self.name]

    def __str__(self) -> str:
        """Write the element."""
        return " ".join([f'"{self.name}"', *(f"{k}={v!r}" for k, v in self.options.items())])


_SECTION_EFFECTS = frozenset({"shear", "torsion", "rotary inertia"})

HIERARCHY = (
    ElementChoice("string", {}, _SECTION_EFFECTS | {"bending"}),
    ElementChoice("thin", {}, _SECTION_EFFECTS),
    ElementChoice("thick", {"section_strain": "nodal"}, frozenset({"shear"})),
    ElementChoice("thick", {"curvature": "section", "section_strain": "nodal"}),
)
"""Elements that plans choose from, from the cheapest to the richest, which neglects nothing."""

CURVED: dict[str, tuple[int, ...]] = {"thin": (2,), "thick": (2, 3)}
"""Elements that have a form with a curved stress-free shape, and its dimensions.

A cable in space has none: the direction of its curvature would be that of a section it lacks.
"""

SLACK: dict[str, tuple[int, ...]] = {"string": (2, 3)}
"""Elements that have a form without compression, and its dimensions."""

PLANAR = tuple(element for element, names in MODULES.items() if 3 not in names)
"""Elements that have no spatial form."""

REFERENCES = ("thick_axis_consistent_gauss",)
"""Modules that serve as references, for tests and benchmarks only."""


def module_names() -> tuple[str, ...]:
    """Return every element module, references left out."""
    return tuple(
        name.format_map(dict(zip(OPTIONS[element], values, strict=True))) + form
        for element, names in MODULES.items()
        for dim, name in names.items()
        for form in _forms(element, dim)
        for values in product(*OPTIONS[element].values())
    )


def _forms(element: str, dim: int) -> tuple[str, ...]:
    """Return the ends of the names of an element's modules of one dimension."""
    table = {"_curved": CURVED, "_slack": SLACK}
    return "", *(form for form, having in table.items() if dim in having.get(element, ()))


def convergence_order(element: object) -> int:
    """Return the order of convergence of an element; the lowest for one built outside."""
    name = element if isinstance(element, str) else ""
    return ORDERS.get(name, min(ORDERS.values()))


def element_kind(
    element: str, dim: int, *, instruction_set: str | None = None, **options: str
) -> ElementKind:
    """Find the kernels of an element.

    Parameters
    ----------
    element : str
        ``"string"``, ``"l2t2"``, ``"thin"`` or ``"thick"``.
    dim : int
        2 for a planar scene, 3 for a spatial one.
    instruction_set : str, optional
        Which build; by default the one in use on this machine.
    **options : str
        ``strain="green"|"biot"`` for thin; ``curvature="axis"|"section"`` and
        ``section_strain="consistent"|"nodal"`` for thick.

    Raises
    ------
    InputError
        If element, option or value does not exist, or the element has no form of that dimension.
    """
    name = _module_name(element, dim, options)
    return from_module(compiled_module(name, instruction_set))


def curved_form(kind: ElementKind) -> ElementKind:
    """Return the form of an element of `CURVED` that is free of strain in a curved shape."""
    return from_module(compiled_module(f"{kind.name}_curved"))


def slack_form(dim: int, transition: float) -> ElementKind:
    """Return the form of a string that transmits no compression.

    Parameters
    ----------
    dim : int
        2 for a planar scene, 3 for a spatial one.
    transition : float
        Strain about which it goes slack.
    """
    kind = from_module(compiled_module(f"{MODULES['string'][dim]}_slack"))
    return kind.with_values(transition=transition)


def _module_name(element: str, dim: int, options: Mapping[str, str]) -> str:
    check_choice("element", element, OPTIONS)
    if dim not in (2, 3):
        raise InputError(f"a scene has 2 or 3 dimensions, not {dim!r}")
    allowed = OPTIONS[element]
    for option, value in options.items():
        if not allowed:
            raise InputError(f"element {element!r} has no options, so {option!r} cannot be set")
        check_choice(f"option of element {element!r}", option, allowed)
        check_choice(option, value, allowed[option])
    choice = {option: options.get(option, values[0]) for option, values in allowed.items()}
    if dim not in MODULES[element]:
        raise InputError(
            f'element "{element}" is planar; in a spatial scene use "thin", '
            "or give the scene a gravity with 2 components"
        )
    return MODULES[element][dim].format_map(choice)
