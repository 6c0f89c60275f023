import pytest

import ancfsparse as ancf
from ancfsparse import integrators
from ancfsparse.dispatch import compiled_module
from ancfsparse.integrators.interface import time_loops
from ancfsparse.integrators.interface.integrator import Integrator
from ancfsparse.integrators.names import BY_NAME, EXAMPLES, EXPLICIT, integrator_of
from ancfsparse.nonlinear import loop_protocols as nonlinear
from ancfsparse.nonlinear.methods import BY_NAME as METHODS
from ancfsparse.seeds.incomplete.factor_protocol import IncompleteFactor
from ancfsparse.seeds.interface import protocols
from ancfsparse.system.assembly.assembly_protocol import CompiledAssembly


def test_every_integrator_has_a_name():
    exported = {getattr(integrators, name) for name in integrators.__all__}
    classes = {type(integrator_of(name)) for name in BY_NAME}
    assert classes == exported - {integrators.Implicit, integrators.Explicit, EXAMPLES}
    assert {text.split("(")[0] for text in EXAMPLES} == {each.__name__ for each in classes}


def test_names_give_what_they_state():
    assert integrator_of("rkn8") == ancf.RungeKuttaNystrom(8)
    assert integrator_of("hht") == ancf.HHT()
    assert integrator_of("generalized-alpha", 0.5) == ancf.GeneralizedAlpha(0.5)
    assert EXPLICIT == ("central-difference", "rkn4", "rkn8", "dormand-prince")
    assert METHODS["bfgs"](memory=3) == ancf.QuasiNewton("bfgs", 3)


@pytest.mark.parametrize("name", BY_NAME)
def test_orders_and_matrices_are_stated(name):
    integrator = integrator_of(name)
    assert isinstance(integrator, Integrator)
    tableau = getattr(integrator, "tableau", None)
    assert integrator.order == (2 if tableau is None else tableau.order)
    assert integrator.stages[-1] == pytest.approx(1.0, abs=1e-15)
    assert integrator.matrices == (2 if integrator.keeps_energy else 1)


def test_damped_newmark_is_of_first_order():
    assert [ancf.Newmark(alpha).order for alpha in (0.0, 0.05)] == [2, 1]


@pytest.mark.parametrize(
    ("protocol", "module", "name"),
    [
        (time_loops.NewmarkLoop, "march", "March"),
        (time_loops.ImplicitLoop, "conserving", "March"),
        (time_loops.ExplicitLoop, "explicit", "Explicit"),
        (nonlinear.NonlinearLoop, "iteration", "Iteration"),
        (nonlinear.DenseInverse, "dense", "Dense"),
        (nonlinear.OwnInverse, "limited", "Limited"),
        (nonlinear.Inverse, "corotated", "Corotated"),
        (CompiledAssembly, "assembly", "Assembly"),
        (protocols.CompleteFactor, "ldl", "Ldl"),
        (IncompleteFactor, "ic", "Ic"),
        (protocols.CompiledSeed, "blocks", "Blocks"),
        (protocols.PythonSeed, "callback", "Callback"),
    ],
)
def test_compiled_objects_have_what_their_types_state(protocol, module, name):
    stated = {
        member
        for base in protocol.__mro__
        for member in (*vars(base), *vars(base).get("__annotations__", ()))
        if not member.startswith("_")
    }
    made = getattr(compiled_module(module), name)
    assert stated
    assert {member for member in stated if not hasattr(made, member)} == set()
