"""Records: the arguments of one call of a method of a scene, as plain data.

A scene is a list of records.  They name bodies instead of holding handles, so they can be compared,
written, changed, and built again in another scene.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, field, is_dataclass, make_dataclass, replace
from inspect import Parameter, signature
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, Self

import numpy as np

from ancfsparse.checks import check_finite, check_integer
from ancfsparse.errors import InputError
from ancfsparse.messages import format_numbers
from ancfsparse.scene.records.compiled_callbacks import is_compiled, picklable_callback
from ancfsparse.scene.records.signal import Signal

if TYPE_CHECKING:
    from ancfsparse.scene.records.plane import Plane

# The record of every method of `Scene` that adds something.
RECORD_TYPES: dict[str, type[Record]] = {}
# References that records hold in place of handles, by their names in files.
REFERENCE_TYPES: dict[str, type[BodyRef]] = {}


class References(Protocol):
    """A scene in which references are resolved to handles.

    Attributes
    ----------
    joints : list of Joint
        The joints that have been added.
    """

    joints: list[Any]

    def body(self, name: str) -> Any:
        """Return the handle of a body."""


@dataclass(frozen=True)
class BodyRef:
    """A body of a scene.

    Parameters
    ----------
    body : str
        Its name.
    """

    body: str

    def __init_subclass__(cls) -> None:
        """Enter the class in the table of references."""
        REFERENCE_TYPES[cls.kind()] = cls

    @classmethod
    def kind(cls) -> str:
        """Return the name of the class in files, such as "Point"."""
        return cls.__name__.removesuffix("Ref")

    def of(self, scene: References) -> Any:
        """Return the handle in a scene."""
        return scene.body(self.body)


REFERENCE_TYPES[BodyRef.kind()] = BodyRef


@dataclass(frozen=True)
class PointRef(BodyRef):
    """A point of a beam, a mesh or a rigid body.

    Its fields are those of `Point`, with the name of the body; along an edge of a mesh `xi` counts
    from the first node of the edge, as given.
    """

    index: int
    xi: float = 0.0
    offsets: tuple[float, ...] = ()

    def of(self, scene: References) -> Any:
        """Return the handle in a scene."""
        return scene.body(self.body).point(self)


@dataclass(frozen=True)
class JointRef(BodyRef):
    """A joint of a scene.

    Parameters
    ----------
    body : str
        Name of a body that it constrains.
    number : int
        Its index in the list of joints of the scene.
    """

    number: int

    def of(self, scene: References) -> Any:
        """Return the handle in a scene."""
        number = check_integer("the number of a joint", self.number)
        if not 0 <= number < len(scene.joints):
            raise InputError(f"the scene has no joint {number}: it has {len(scene.joints)} joints")
        return scene.joints[number]


At = Callable[[BodyRef], str]
_NUMPY = np.ndarray, np.generic


@dataclass(frozen=True, eq=False)
class Record:
    """The arguments of one call; its fields have the names of the parameters.

    Vectors are tuples, matrices read-only arrays, handles `BodyRef` or `PointRef`.

    Attributes
    ----------
    method : str
        Method of `Scene` that was called.
    units : dict of str to str
        Units of its numbers, by field.
    planar : dict of str to str, or None
        Forms of its fields in a planar scene: ``"put"`` for positions, ``"into"`` for vectors,
        ``"across"`` for vectors normal to the plane, ``"absent"`` for those without one.  None if
        it has no planar form.
    """

    method: ClassVar[str]
    units: ClassVar[Mapping[str, str]] = {}
    planar: ClassVar[Mapping[str, str] | None] = None

    def __init_subclass__(cls) -> None:
        """Enter the class in the table of records."""
        if "method" in cls.__dict__:
            RECORD_TYPES[cls.method] = cls

    def __post_init__(self) -> None:
        """Normalise NumPy vectors to tuples and NumPy scalars to Python numbers."""
        for name, value in self.__dict__.items():
            if isinstance(value, _NUMPY) and value.ndim < 2:
                self.__dict__[name] = tuple(value.tolist()) if value.ndim else value.item()

    @property
    def given(self) -> dict[str, Any]:
        """All fields by name."""
        return dict(self.__dict__)

    def build(self, scene: References) -> Any:
        """Call the method of a scene with the arguments; return the handle."""
        handles = {
            k: mapped(value, lambda reference: reference.of(scene))
            for k, value in self.given.items()
        }
        return getattr(scene, self.method)(**handles)

    def moved(self, move: Callable[[BodyRef], BodyRef]) -> Self:
        """Return a copy with other references."""
        return replace(self, **{name: mapped(value, move) for name, value in self.given.items()})

    def project(self, handle: Any, plane: Plane) -> Record:
        """Return the record for a planar scene; `handle` was built from it.

        Raises
        ------
        LeavesPlaneError
            If it has no planar form, or anything leaves the plane.
        """
        if self.planar is None:
            plane.refuse()
        forms = {
            name: form
            for name, form in self.planar.items()
            if not isinstance(getattr(self, name), BodyRef)
        }
        return replace(self, **{k: plane.project(getattr(self, k), forms[k]) for k in forms})

    def describe(self, at: At, made: Any) -> str:
        """Describe the arguments that determine the motion, for the digest of a scene.

        Parameters
        ----------
        at : callable
            Function that describes a reference.
        made : object
            The handle that was built from the record.
        """
        values = ", ".join(f"{name} {text(value, at)}" for name, value in self.given.items())
        return f"{self.method}: {values}"

    def __eq__(self, other: object) -> bool:
        """Compare all fields."""
        return type(self) is type(other) and all(
            equal(value, getattr(other, name)) for name, value in self.given.items()
        )

    __hash__ = None  # type: ignore[assignment]

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling, with functions in a form that can be pickled."""
        return {
            name: picklable_callback(value, self.method) for name, value in self.__dict__.items()
        }


def record_type(
    name: str,
    method: Callable[..., Any],
    base: type[Record] = Record,
    units: Mapping[str, str] | None = None,
    planar: Mapping[str, str] | None = None,
) -> type[Any]:
    """Return the class of the records of a method, with its parameters as fields.

    Parameters
    ----------
    name : str
        Name of the class in the module of the method.
    method : callable
        The method of `Scene`.
    base : type, optional
        Its base class, which may describe it.
    units : dict of str to str, optional
        Units of its numbers, by field.
    planar : dict of str to str, optional
        Forms of its fields in a planar scene.
    """
    fields = [
        (
            each.name,
            Any,
            field(
                default=MISSING if each.default is Parameter.empty else each.default,
                kw_only=each.kind is Parameter.KEYWORD_ONLY,
            ),
        )
        for each in [*signature(method).parameters.values()][1:]
    ]
    namespace = {
        "__doc__": f"The record of `Scene.{method.__name__}`.",
        "method": method.__name__,
        "units": units or {},
        "planar": planar,
    }
    made = make_dataclass(name, fields, bases=(base,), namespace=namespace, frozen=True, eq=False)
    made.__module__ = method.__module__  # which Python 3.12 and later overwrite in the namespace
    return made


def mapped(value: Any, change: Callable[[BodyRef], Any]) -> Any:
    """Return the value of a field with its references changed, also inside tuples."""
    if isinstance(value, BodyRef):
        return change(value)
    if isinstance(value, tuple):
        return tuple(mapped(item, change) for item in value)
    return value


def equal(one: Any, other: Any) -> bool:
    """Return True if two values of a field are equal; functions are equal if identical."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    return bool(one == other)


def text(value: Any, at: At) -> str:
    """Return a value as text for a digest, numbers with nine digits."""
    if isinstance(value, tuple) and value:
        return "; ".join(map(at, value)) if isinstance(value[0], BodyRef) else format_numbers(value)
    if isinstance(value, BodyRef):
        return at(value)
    if isinstance(value, Signal):
        return value.describe()
    if callable(value) or is_compiled(value):
        return "a function of time"
    if isinstance(value, bool | str) or value is None:
        return str(value)
    return format_numbers(value)


def as_data(value: Any) -> Any:
    """Return an argument as plain data: numbers, tuples of numbers, or a read-only matrix.

    None, functions and dataclasses such as an `Arc` are returned as they are.  Numbers of single
    precision become their decimals, as when they are checked.
    """
    if value is None or callable(value) or is_dataclass(value):
        return value
    array = np.array(value, dtype=float)
    array.flags.writeable = False
    if array.ndim > 1:
        return array
    return tuple(array.tolist()) if array.ndim else check_finite("a number", value)
