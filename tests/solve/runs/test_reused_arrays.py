"""A function may return the same array at every call: what it returned is copied."""

import inspect
import typing
from collections.abc import Callable

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.scene.geometry import curves, splines
from ancfsparse.scene.meshing import eigenstrain
from ancfsparse.scene.records.signal import Signal

ANCHOR = (2.0, 1.0)
DISTANCE = 2**0.5


def reusing(function, *arguments):
    """Return a function that writes its results into one array."""
    array = np.zeros(np.shape(function(*arguments)))

    def write(*now):
        array[...] = function(*now)
        return array

    return write


def far(t):
    return (1.0 + 0.1 * t**3, 0.0)


def length(t):
    return DISTANCE + 0.1 * t**3


def rate(t):
    return 0.3 * t**2


def second_rate(t):
    return 0.6 * t


def along(function):
    return lambda t: (function(t), 0.0)


def load(t):
    return (0.0, 10.0 * np.sin(30.0 * t))


def turn(t):
    return 0.2 * np.sin(30.0 * t)


RATES = {"rate": rate, "second_rate": second_rate}
PLANE_RATES = {"rate": along(rate), "second_rate": along(second_rate)}
# The arguments of each method that are functions, and its call with them.
METHODS = {
    "point_force": ({"value": load}, lambda scene, rod, f: scene.point_force(rod.end, **f)),
    "point_moment": ({"value": turn}, lambda scene, rod, f: scene.point_moment(rod.end, **f)),
    "distributed_force": (
        {"value": load, "shape": lambda s: s},
        lambda scene, rod, f: scene.distributed_force(rod, **f),
    ),
    "changing_gravity": ({"value": load}, lambda scene, rod, f: scene.changing_gravity(**f)),
    "drive": (
        {"position": far} | PLANE_RATES,
        lambda scene, rod, f: scene.drive(rod.end, **f),
    ),
    "drive_joint": (
        {"value": lambda t: t**3, "rate": lambda t: 3.0 * t**2, "second_rate": lambda t: 6.0 * t},
        lambda scene, rod, f: scene.drive_joint(scene.pin(rod.start), **f),
    ),
    "rod": ({"length": length} | RATES, lambda scene, rod, f: scene.rod(rod.end, ANCHOR, **f)),
    "distance": (
        {"length": length} | RATES,
        lambda scene, rod, f: scene.distance(rod.end, add_sphere(scene).origin, **f),
    ),
    "winch": (
        {"length": length} | RATES,
        lambda scene, rod, f: scene.winch([ANCHOR, rod.end], **f),
    ),
    "rope": (
        {"length": length},
        lambda scene, rod, f: scene.rope([ANCHOR, rod.end], stiffness=1e3, **f),
    ),
    "force": (
        {"function": lambda q, v, t: -100.0 * (q - 1.0) - v},
        lambda scene, rod, f: scene.force([rod.end], **f),
    ),
}
# Names in annotations that their modules import for types alone.
OTHERS = dict.fromkeys(("BeamContact", "Contact", "Obstacle", "RigidBody"), object)
TYPES = OTHERS | {"Signal": Signal} | vars(curves) | vars(splines) | vars(eigenstrain)
EACH = [
    (method, tuple(name for name in functions if name in kind))
    for method, (functions, _) in METHODS.items()
    for kind in ({"value", "position", "length", "function"}, {"rate", "second_rate"}, {"shape"})
    if kind & functions.keys()
]


def add_mesh(scene, **given):
    return scene.add_mesh([(0, 0), (1, 0)], [(0, 1)], "thin", *MADE, n_elements=4, **given)


def add_beam(scene, element="thin", **given):
    ends = ((0.0,) * scene.dim, (1.0,) + (0.0,) * (scene.dim - 1)) if "curve" not in given else ()
    section, material = MADE
    return scene.add_beam(element, *ends, n_elements=4, section=section, material=material, **given)


def columns(*functions):
    return lambda x: np.column_stack([function(x) for function in functions])


MADE = ancf.Rectangle(0.01, 0.02), ancf.Material(1e8, 4000)
SPIN = columns(lambda x: 0.0 * x[:, 0], lambda x: 3.0 * x[:, 0])
# Arguments that are functions of arrays or of numbers other than the time: the dimension, the
# function, and the call with it.
OF_ARRAYS = {
    ("add_beam", "velocity"): (2, SPIN, add_beam),
    ("add_mesh", "velocity"): (2, SPIN, add_mesh),
    ("add_beam", "curve"): (2, columns(lambda u: u, lambda u: 0.1 * np.sin(2.0 * u)), add_beam),
    ("add_beam", "up"): (3, columns(lambda s: 0.0 * s, np.sin, np.cos), add_beam),
    ("add_beam", "twist"): (3, lambda s: 0.5 * s**2, add_beam),
    ("add_beam", "eigenstrain"): (2, lambda s: np.array(0.01 * s), add_beam),
    ("add_beam", "eigencurvature"): (3, lambda s: np.array([0.1 * s, 0.2 * s]), add_beam),
    ("spring", "stiffness"): (
        2,
        lambda e: np.array(100.0 * e + 1e3 * e**3),
        lambda scene, **given: scene.spring(add_beam(scene).end, (1.5, 0.0), **given),
    ),
}


def add_sphere(scene):
    return scene.add_body(ancf.Sphere(0.1), position=ANCHOR, mass=1.0)


def motion(method, names, wrap):
    functions, call = METHODS[method]
    functions = {k: wrap(f) if k in names else f for k, f in functions.items()}
    scene = ancf.Scene(gravity=(0, -9.81))
    section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000)
    rod = scene.add_beam("thin", (0, 0), (1, 0), 4, section, material)
    if method != "drive_joint":
        scene.pin(rod.start)
    call(scene, rod, functions)
    return ancf.simulate(scene, 0.05, 1e-3).q


def is_function(hint):
    """Return whether one of the types that a hint allows is a function."""
    types = (typing.get_origin(hint) or hint, *map(is_function, typing.get_args(hint)))
    return any(each is Callable or each is True for each in types)


def test_every_argument_that_takes_a_function_is_here():
    found = set()
    for method in dir(ancf.Scene):
        function = getattr(ancf.Scene, method)
        if not method.startswith("_") and inspect.isfunction(function):
            hints = typing.get_type_hints(function, localns=TYPES)
            found |= {(method, name) for name, hint in hints.items() if is_function(hint)}
    here = {(method, name) for method, (each, _) in METHODS.items() for name in each}
    assert found == here | set(OF_ARRAYS)


@pytest.mark.parametrize(("method", "names"), EACH, ids=str)
def test_a_function_may_return_one_array_again_and_again(method, names):
    first = (np.ones((1, 2)), np.zeros((1, 2)), 0.0) if method == "force" else (0.0,)

    def same(function):
        return reusing(function, *first)

    def fresh(function):
        write = same(function)
        return lambda *now: write(*now).copy()

    np.testing.assert_array_equal(motion(method, names, same), motion(method, names, fresh))


@pytest.mark.parametrize("argument", OF_ARRAYS, ids=" ".join)
def test_a_function_of_places_may_return_one_array_too(argument):
    """Slopes began without the rates of a velocity that returned one array."""
    dim, function, call = OF_ARRAYS[argument]
    element = {} if dim == 2 else {"element": "thick"}
    arrays = {}

    def same(x):
        now = function(x)
        array = arrays.setdefault(np.shape(now), np.zeros(np.shape(now)))
        array[...] = now
        return array

    states = []
    for each in (function, same):
        scene = ancf.Scene(gravity=(0.0, -9.81, 0.0)[:dim])
        call(scene, **{argument[1]: each}, **element)
        states.append(ancf.simulate(scene, 0.01, 1e-3))
    np.testing.assert_array_equal(states[0].q, states[1].q)
    np.testing.assert_array_equal(states[0].v, states[1].v)


@pytest.mark.parametrize("argument", OF_ARRAYS, ids=" ".join)
def test_a_function_of_places_that_fails_is_named(argument):
    def fail(_):
        raise KeyError("boom")

    dim, _, call = OF_ARRAYS[argument]
    element = {} if dim == 2 else {"element": "thick"}
    with pytest.raises(ancf.InputError, match=r"failed.*: KeyError: 'boom'"):
        call(ancf.Scene(gravity=(0.0,) * dim), **{argument[1]: fail}, **element)
