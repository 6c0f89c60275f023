"""Kinds of elements, as their compiled modules declare them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import import_module
from types import MappingProxyType, ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_finite
from ancfsparse.dispatch import compiled_module, instruction_set
from ancfsparse.errors import InputError

REFERENCE = "reference_"
"""Prefix of the parameters for coordinates of a stress-free shape, followed by their numbers."""

RIGID = "rigid"
"""Name in place of an element for rigid bodies, which have none."""


@dataclass(frozen=True, eq=False, repr=False)
class ElementKind:
    """Coordinates, parameters and kernels of an element, as declared by its module.

    Elements of this package have names for `Scene.add_beam`; an element built outside it
    (`ancfsparse.kernels.building`) is passed itself.

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
        Nodal vectors that rotate with the section, such as ``r_y``, on which clamps and moments
        act.  A cable has only the direction of ``r_x``, a string none.
    parameters : tuple of str
        Base parameters in the order of ``prepare``, SI units.
    n_derived : int
        Number of derived parameters per element.
    operations, sizes : mapping
        Arithmetic operations per element of each kernel, and number of its results.
    prepare : callable
        Base parameters (n, n_base) to derived ones (n, n_derived).
    kernels : mapping
        Capsules by name; see `kernel_abi.h` and the generated `kernel_list.h`.
    definition : str
        Digest of coordinates, energy and inertia.
    package : str
        The package it was built in, empty for elements of this one.
    own : mapping
        Names of the parameters of this element only, and the group of each, which determines its
        damping: ``"stretching"``, ``"turning"``, ``"masses"`` or ``"ratios"``.
    values : mapping
        Their values, SI units.
    """

    name: str
    dim: int
    lanes: int
    node_coordinates: tuple[str, ...]
    section: tuple[str, ...]
    parameters: tuple[str, ...]
    n_derived: int
    operations: Mapping[str, int]
    sizes: Mapping[str, int]
    prepare: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    kernels: Mapping[str, object]
    definition: str
    package: str = ""
    own: Mapping[str, str] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)
    n_nodes: int = 2

    def __repr__(self) -> str:
        """Return name, definition and values, on which a run depends."""
        values = "".join(f", {name} = {value:.9g}" for name, value in self.values.items())
        return f"{self.name} {self.definition}{values}"

    def __eq__(self, other: object) -> bool:
        """Compare definitions, values and packages."""
        return isinstance(other, ElementKind) and self._identity == other._identity

    def __hash__(self) -> int:
        """Return the hash, equal for equal elements."""
        return hash(self._identity)

    @property
    def _identity(self) -> tuple[Any, ...]:
        values = tuple(sorted(self.values.items()))
        return self.name, self.node_coordinates, self.package, self.definition, self.lanes, values

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the name: another process loads the module for its machine."""
        if self.name == RIGID:
            return rigid_kind, (self.dim, len(self.section))
        return _loaded, (self.name, self.package, dict(self.values))

    @property
    def n_coordinates(self) -> int:
        """Coordinates of one element."""
        return self.n_nodes * len(self.node_coordinates)

    @property
    def is_cable(self) -> bool:
        """True if the slope is the only vector of a node that rotates with the section."""
        return self.section == ("r_x",)

    @property
    def is_string(self) -> bool:
        """True if its nodes have positions only: it is straight, without bending stiffness."""
        return self.vectors == ("r",)

    @property
    def axis(self) -> tuple[str, ...]:
        """Vectors of a node that determine the axis."""
        return self.vectors[:2]

    @property
    def is_curved(self) -> bool:
        """True if its parameters include the coordinates of a stress-free shape."""
        return f"{REFERENCE}0" in self.parameters

    @property
    def bends_alike(self) -> bool:
        """True if its bending stiffness in space is isotropic."""
        return self.dim == 3 and "bending_stiffness" in self.parameters

    def columns(self, vector: str) -> slice:
        """Return the columns of a vector, such as ``r`` or ``r_y``, in the coordinates of a node.

        The slice is empty if the element has no such vector.
        """
        return _columns(self.node_coordinates, vector)

    def directions(self, vector: str) -> list[int]:
        """Return the directions in space, 0 to 2, of those coordinates."""
        return [int(label[-1]) - 1 for label in self.node_coordinates[self.columns(vector)]]

    def vector_of(self, column: int) -> str:
        """Return the vector to which a coordinate of a node belongs."""
        return _vector(self.node_coordinates[column])

    @property
    def vectors(self) -> tuple[str, ...]:
        """Vectors of a node in order, ``r`` first, then ``r_x`` if there is one."""
        return _vectors(self.node_coordinates)

    def n_out(self, kernel: str) -> int:
        """Return the number of results of a kernel per element."""
        return self.sizes[kernel]

    def with_values(self, **values: float) -> ElementKind:
        """Return this element with values of its own parameters.

        Parameters
        ----------
        **values : float
            A value for each, SI units.

        Raises
        ------
        InputError
            If a name is unknown, or a value is not finite.
        """
        for name in values:
            if name not in self.own:
                has = ", ".join(self.own) or "none"
                raise InputError(
                    f"element {self.name} has no own parameter {name!r} (its own: {has})"
                )
        checked = {k: check_finite(f"{k} of element {self.name}", v) for k, v in values.items()}
        return replace(self, values=MappingProxyType({**self.values, **checked}))


def rigid_kind(dim: int, vectors: int) -> ElementKind:
    """Return the coordinates of a rigid body, which has no kernels.

    Parameters
    ----------
    dim : int
        Dimension of the scene.
    vectors : int
        Number of its unit vectors.
    """
    names = ("r_x", "r_y", "r_z")[:vectors]
    return ElementKind(
        name=RIGID,
        dim=dim,
        lanes=1,
        node_coordinates=tuple(f"{each}{d + 1}" for each in ("r_", *names) for d in range(dim)),
        section=names,
        parameters=(),
        n_derived=0,
        operations=defaultdict(int),
        sizes=defaultdict(int),
        prepare=lambda base: base,
        kernels={},
        definition="",
    )


def _vector(label: str) -> str:
    """Return the vector of a coordinate: ``r`` of ``r_1``, ``r_x`` of ``r_x1``."""
    return label[:-1].rstrip("_")


@cache
def _vectors(labels: tuple[str, ...]) -> tuple[str, ...]:
    """Return the vectors of coordinates in order."""
    return tuple(dict.fromkeys(map(_vector, labels)))


@cache
def _columns(labels: tuple[str, ...], vector: str) -> slice:
    """Return the columns of a vector in coordinates."""
    columns = [k for k, label in enumerate(labels) if _vector(label) == vector]
    return slice(columns[0], columns[-1] + 1) if columns else slice(0, 0)


@cache
def from_module(module: ModuleType, package: str = "") -> ElementKind:
    """Return the element that a compiled kernel module declares.

    Parameters
    ----------
    module : module
        The module.
    package : str, optional
        The package it was built in, if not this one.

    Raises
    ------
    InputError
        If it was built for another version of the calling convention.
    """
    if package:  # those of this package are built with it
        convention = compiled_module("kernel_call").SIGNATURE
        if getattr(module, "SIGNATURE", None) != convention:
            raise InputError(
                f"element {module.NAME} was built for the calling convention "
                f"{getattr(module, 'SIGNATURE', 'of an earlier version')}, and this version of "
                f"ancfsparse has {convention}: build it again with `ancfsparse element`"
            )
    return ElementKind(
        name=module.NAME,
        dim=module.DIM,
        lanes=module.LANES,
        node_coordinates=module.NODE_COORDINATES,
        section=module.SECTION,
        parameters=module.PARAMETERS,
        n_derived=module.N_DERIVED,
        operations=module.OPERATIONS,
        sizes=module.SIZES,
        prepare=module.prepare,
        kernels=module.kernels,
        definition=module.DEFINITION,
        package=package,
        own=module.OWN_PARAMETERS,
        n_nodes=module.N_NODES,
    )


@cache
def external_element(package: str) -> ElementKind:
    """Return the element of a package that ``ancfsparse element`` has built from a file.

    Parameters
    ----------
    package : str
        Name of the package, as it is imported; its ``ELEMENT`` is the value of this function.

    Raises
    ------
    InputError
        If it cannot be imported, or was not built for this machine or this version.
    """
    name = package.rpartition(".")[2]
    module = f"{package}.{name}_{instruction_set()}"
    try:
        found = import_module(module)
    except ModuleNotFoundError as missing:
        if missing.name == module:
            raise InputError(
                f"element {name} was not built for instruction set {instruction_set()} and this "
                "Python: build it again with `ancfsparse element`, on this machine or with "
                f"--instruction-set {instruction_set()}"
            ) from None
        raise InputError(
            f"element {name} is in the package {package}, which cannot be imported here: put the "
            "folder that contains it into PYTHONPATH, or build it again with `ancfsparse element`"
        ) from None
    return from_module(found, package)


def _loaded(name: str, package: str, values: Mapping[str, float]) -> ElementKind:
    """Return a pickled element."""
    if package:
        kind = external_element(package)
    else:
        kind = from_module(compiled_module(name))
    return kind.with_values(**values) if values else kind
