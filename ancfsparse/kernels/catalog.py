"""The elements there are, in the user's words, and what their modules say about themselves."""

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_choice
from ancfsparse.dispatch import compiled
from ancfsparse.errors import InputError

OPTIONS: dict[str, dict[str, tuple[str, ...]]] = {
    "l2t2": {},
    "thin": {"strain": ("green", "biot")},
    "thick": {"curvature": ("axis", "section"), "section_strain": ("consistent", "nodal")},
}
"""Elements, their options, and the values of each; the first value is the default."""

MODULES: dict[str, dict[int, str]] = {
    "l2t2": {2: "l2t2"},
    "thin": {2: "thin_planar_{strain}", 3: "thin_spatial_{strain}"},
    "thick": {
        3: "thick_{curvature}_{section_strain}",
        2: "thick_planar_{curvature}_{section_strain}",
    },
}
"""Names of the modules of every element, by the dimensions it has, with its options in them."""

PLANAR = tuple(element for element, names in MODULES.items() if 3 not in names)
"""Elements that have no spatial form."""

RIGID = "rigid"
"""What rigid bodies, which have no elements, have in the place of an element's name."""

REFERENCES = ("thick_axis_consistent_gauss",)
"""Modules that are there to be compared with, for tests and benchmarks only."""


@dataclass(frozen=True)
class ElementKind:
    """What assembly needs to know about an element; a user's own element fills the same form.

    Attributes
    ----------
    name : str
        Name of the kernel module.
    dim : int
        Dimension of the scene, 2 or 3.
    lanes : int
        Elements per block.
    node_coordinates : tuple of str
        Labels of one node's coordinates in order, such as ``r_1``, ``r_x2``: vector and direction.
    section : tuple of str
        Nodal vectors that turn with the section, such as ``r_y``: what a clamp holds and a moment
        acts on.  A cable has no section but the direction of ``r_x``.
    parameters : tuple of str
        Base parameters in the order ``prepare`` takes them, SI units.
    n_derived : int
        Number of derived parameters per element.
    operations : mapping
        Arithmetic operations per element of each kernel.
    prepare : callable
        Base parameters (n, n_base) to derived ones (n, n_derived).
    kernels : mapping
        Capsules by name: energy, force, inertia, residual, tangent, mass, damping, material,
        discrete_gradient; see `kernel_abi.h`.
    """

    name: str
    dim: int
    lanes: int
    node_coordinates: tuple[str, ...]
    section: tuple[str, ...]
    parameters: tuple[str, ...]
    n_derived: int
    operations: Mapping[str, int]
    prepare: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    kernels: Mapping[str, object]
    n_nodes: int = 2

    @property
    def n_coordinates(self) -> int:
        """Coordinates of one element."""
        return self.n_nodes * len(self.node_coordinates)

    @property
    def is_cable(self) -> bool:
        """Whether a node knows no more of the section than the direction of its slope."""
        return self.section == ("r_x",)

    def columns(self, vector: str) -> list[int]:
        """Return where the components of a nodal vector stand among the coordinates of a node."""
        return [k for k, label in enumerate(self.node_coordinates) if label[:-1] == vector]

    def n_out(self, kernel: str) -> int:
        """Numbers a kernel adds per element."""
        n = self.n_coordinates
        triangle = n * (n + 1) // 2
        sizes = {"energy": 1, "tangent": triangle, "mass": triangle, "material": triangle}
        return sizes.get(kernel, n)


def rigid_kind(dim: int, vectors: str) -> ElementKind:
    """Return the coordinates of a rigid body, which has no kernels.

    Parameters
    ----------
    dim : int
        Dimension of the scene.
    vectors : str
        Number of its unit vectors.
    """
    names = ("r_x", "r_y", "r_z")[: int(vectors)]
    return ElementKind(
        name=RIGID,
        dim=dim,
        lanes=1,
        node_coordinates=tuple(f"{each}{d + 1}" for each in ("r_", *names) for d in range(dim)),
        section=names,
        parameters=(),
        n_derived=0,
        operations=defaultdict(int),
        prepare=lambda base: base,
        kernels={},
    )


def from_module(module: ModuleType) -> ElementKind:
    """Read what a compiled kernel module exposes."""
    return ElementKind(
        name=module.NAME,
        dim=module.DIM,
        lanes=module.LANES,
        node_coordinates=module.NODE_COORDINATES,
        section=module.SECTION,
        parameters=module.PARAMETERS,
        n_derived=module.N_DERIVED,
        operations=module.OPERATIONS,
        prepare=module.prepare,
        kernels=module.kernels,
        n_nodes=module.N_NODES,
    )


def module_names() -> tuple[str, ...]:
    """Return every element module, references left out."""
    return tuple(
        name.format_map(dict(zip(OPTIONS[element], values, strict=True)))
        for element, names in MODULES.items()
        for name in names.values()
        for values in product(*OPTIONS[element].values())
    )


def element_kind(
    element: str, dim: int, *, instruction_set: str | None = None, **options: str
) -> ElementKind:
    """Find the kernels of an element.

    Parameters
    ----------
    element : str
        ``"l2t2"``, ``"thin"`` or ``"thick"``.
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
    if element == RIGID:
        return rigid_kind(dim, **options)
    name = _module_name(element, dim, options)
    return from_module(compiled(name, instruction_set))


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
