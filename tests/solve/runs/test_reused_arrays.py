"""A function may return the same array at every call: what it returned is copied."""

import inspect

import numpy as np
import pytest

import ancfsparse as ancf

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
EACH = [
    (method, tuple(name for name in functions if name in kind))
    for method, (functions, _) in METHODS.items()
    for kind in ({"value", "position", "length", "function"}, {"rate", "second_rate"}, {"shape"})
    if kind & functions.keys()
]


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


def test_every_argument_that_takes_a_function_is_here():
    found = {
        (method, name)
        for method in dir(ancf.Scene)
        if not method.startswith("_") and inspect.isfunction(getattr(ancf.Scene, method))
        for name, given in inspect.signature(getattr(ancf.Scene, method)).parameters.items()
        if "Callable" in str(given.annotation) or "Function" in str(given.annotation)
    }
    assert found == {(method, name) for method, (each, _) in METHODS.items() for name in each}


@pytest.mark.parametrize(("method", "names"), EACH, ids=str)
def test_a_function_may_return_one_array_again_and_again(method, names):
    first = (np.ones((1, 2)), np.zeros((1, 2)), 0.0) if method == "force" else (0.0,)

    def same(function):
        return reusing(function, *first)

    def fresh(function):
        write = same(function)
        return lambda *now: write(*now).copy()

    np.testing.assert_array_equal(motion(method, names, same), motion(method, names, fresh))
