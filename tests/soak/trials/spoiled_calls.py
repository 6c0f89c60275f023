"""Public callables with spoiled arguments: a result, or an error of the package in one sentence.

Callables and their parameters are found by inspection; `given` has valid arguments, by the name of
the parameter or of the callable.  Hypothesis spoils one or two of them and shrinks what breaks.
"""

import contextlib
import inspect
import tempfile
import warnings
from functools import cache

import matplotlib.pyplot as plt
from hypothesis import strategies as st

import ancfsparse as ancf
from tests.soak.report import Report, search
from tests.soak.trials.odd_values import ODD_VALUES
from tests.soak.world import GIVEN, World

AT_ONCE = 40  # calls in a trial
MAX_LETTERS = 1000  # of the sentence of an error
ON_PURPOSE = (
    ancf.UnstableEquilibriumWarning,
    ancf.RedundantConstraintsWarning,
    ancf.ApproximateModesWarning,
    ancf.ErrorNotMetWarning,
    ancf.UnresolvedSignalWarning,
)
# Classes that users get and do not make.
RESULTS = (ancf.Trajectory, ancf.Equilibrium, ancf.Plan, ancf.State, Exception)
SIGNALS = (ancf.Ramp, ancf.Sine, ancf.Pulse, ancf.Table)
OBJECTS = {
    "Scene": "scene", "Trajectory": "run", "Equilibrium": "rest", "Modes": "shapes",
    "ComplexModes": "complex_shapes", "LoadPath": "path", "Buckling": "buckled",
    "Assembly": "assembly", "Plan": "plan",
}  # fmt: skip
HANDLES = {
    "Beam.node": ("rod", "node"), "Beam.at": ("rod", "at"), "Mesh.node": ("net", "node"),
    "Mesh.at": ("net", "at"), "RigidBody.at": ("box", "at"), "Motion.body": ("motion", "body"),
}  # fmt: skip


@cache
def find_calls():
    """Return the owner in a `World` and the name of each public callable, by its label."""
    world, found = World(3), {}
    for name in ancf.__all__:
        each = getattr(ancf, name)
        is_made_by_users = not (inspect.isclass(each) and issubclass(each, RESULTS))
        if callable(each) and is_made_by_users:
            found[name] = ("", name)
    for label, owner in OBJECTS.items():
        for method in dir(type(getattr(world, owner))):
            if not method.startswith("_") and callable(getattr(getattr(world, owner), method)):
                found[f"{label}.{method}"] = (owner, method)
    found |= HANDLES
    del found["Trajectory.body"]  # of a motion with a body, which is in HANDLES
    variants = {label: label.partition(",")[0] for label in GIVEN if "," in label}
    return found | {label: found[name] for label, name in variants.items()}


def function_of(world, name):
    """Return a callable of a world."""
    owner, method = find_calls()[name]
    return getattr(getattr(world, owner) if owner else ancf, method)


@cache
def parameters_of(name):
    """Return the names of the parameters of a callable, keywords of its own included."""
    world = World(3)
    signature = inspect.signature(function_of(world, name)).parameters
    variable = (inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL)
    named = [key for key, each in signature.items() if each.kind not in variable]
    return list(dict.fromkeys([*named, *GIVEN.get(name, lambda world: {})(world)]))


def call(name, dim, spoiled):
    """Call with spoiled arguments and use the result; return the sentence of a refusal, or None.

    Any other error, a warning, and a refusal without a sentence raise an error with the call.
    """
    world = World(dim)
    words = ", ".join(f"{key}={label}" for key, (label, _) in spoiled.items())
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            function = function_of(world, name)
            arguments = world.given(name, inspect.signature(function).parameters)
            arguments |= {key: make() for key, (_, make) in spoiled.items()}
            use(world, name, bound(function, arguments))
            text = None
        except ancf.AncfError as refused:
            text = str(refused)
        except Exception as raw:
            what = f"{type(raw).__name__}: {' '.join(str(raw).split())[:150]}"
            raise AssertionError(f"{name}({words}) raised {what}") from raw
        finally:
            plt.close("all")
    # A contact of 1e-30 N/m2 does not hold anything, and a run says so.
    right = (*ON_PURPOSE, *([ancf.PenetrationWarning] if "stiffness" in spoiled else []))
    foreign = [each for each in caught if not issubclass(each.category, right)]
    assert not foreign, (
        f"{name}({words}) warned: {foreign[0].category.__name__}: {foreign[0].message}"
    )
    if text is not None:
        is_sentence = "\n" not in text and 10 < len(text) < MAX_LETTERS
        assert is_sentence, f"{name}({words}) was refused by no sentence: {text[:80]!r}"
    return text


def bound(function, arguments):
    """Call a function by the names of its parameters, those that are positional only too."""
    signature = inspect.signature(function).parameters.values()
    first = [each.name for each in signature if each.kind is each.POSITIONAL_ONLY]
    values = [arguments.pop(name) for name in first if name in arguments]
    return function(*values, **arguments)


def use(world, name, result):
    """Use a result: run a scene that was changed or a load of it, plan for a quantity."""
    if isinstance(result, SIGNALS):
        world.scene.point_force(world.rod.end, result)
    if isinstance(result, type(ancf.energy())):
        ancf.plan(world.held, 2e-3, result, 1e-2)
    if name.startswith("Scene.") or isinstance(result, SIGNALS):
        ancf.simulate(world.scene, 2e-3, 1e-3)
        if name != "Scene.force":  # its function is in no file
            world.scene.save("recorded.json")
            assert ancf.Scene.load("recorded.json").digest() == world.scene.digest()


@st.composite
def spoiled_calls(draw):
    """Draw a callable, the dimension of its scene, and one or two spoiled arguments."""
    name = draw(st.sampled_from([name for name in find_calls() if parameters_of(name)]))
    names = st.lists(st.sampled_from(parameters_of(name)), min_size=1, max_size=2, unique=True)
    return name, draw(st.sampled_from([2, 3])), {each: draw(ODD_VALUES) for each in draw(names)}


def run(number, index):
    """Search for a call that breaks, and reduce it."""
    refused = []

    def check(*spoiled):
        refused.append(call(*spoiled) is not None)

    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        raw = search(number, index, spoiled_calls(), check, AT_ONCE)
    if raw is not None:
        return Report("broke", [str(raw).splitlines()[0]], "a call")
    return Report("called", [], f"{len(refused)} calls, {sum(refused)} refused")
