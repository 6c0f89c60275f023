"""What plans would gain by adjoint solutions, by the prototype that docs/model.md reports on."""

import numpy as np
import pytest

import ancfsparse as ancf
from benchmarks.adjoints import estimates as adjoints


def test_the_adjoint_is_the_transpose_of_the_tangent():
    run, node = adjoints.integrate(adjoints.cantilever, 4, 0.2, 40)
    steps = adjoints.LinearizedSteps(run.system, *adjoints.halve_steps(run))
    moved = steps.tangent()[-1]
    for goal in adjoints.gradient(run.system, node):
        assert steps.adjoint(goal)[0] == pytest.approx(goal @ moved, rel=1e-6)


def test_the_tangent_of_the_run_itself_is_zero():
    """Its own states violate its own steps by no more than the tolerance of the solver."""
    run, _ = adjoints.integrate(adjoints.pendulum, 4, 0.2, 40)
    states = [np.asarray(each) for each in (run.q, run.v, run.a)]
    off = adjoints.LinearizedSteps(run.system, run.t, states).tangent()
    assert np.abs(off).max() < 1e-5 * np.ptp(states[0])


@pytest.mark.parametrize("name", adjoints.STATICS)
def test_of_equilibria_the_adjoint_estimates_well_at_less_work(name):
    true, one, other, mine, its = adjoints.compare_equilibrium(adjoints.STATICS[name], 12)
    assert 0.7 < one / true < 1.3
    assert 0.7 < other / true < 1.3
    assert mine < 0.6 * its


def test_of_motions_the_adjoint_takes_more_work_than_a_finer_run():
    """Both estimate about as well, and the finer run is one more answer."""
    mesh, steps, growth, size = adjoints.compare_motion(adjoints.cantilever, 0.3, 6, 100)
    for true, one, other, mine, its in (mesh, steps):
        assert 0.6 < one / true < 1.5
        assert 0.6 < other / true < 1.5
        assert mine > 1.3 * its
        assert not adjoints.has_blown_up(one, size)
    assert growth < 10.0


@pytest.mark.slow
def test_of_a_chaotic_motion_the_adjoint_blows_up_where_plans_fail():
    run, node = adjoints.integrate(adjoints.double, 1, 10.0, 2000)
    steps = adjoints.LinearizedSteps(run.system, *adjoints.halve_steps(run))
    swept = [steps.adjoint(goal) for goal in adjoints.gradient(run.system, node)]
    places = run.position(node)
    size = np.linalg.norm(places - places[0], axis=1).max()
    assert adjoints.has_blown_up(np.hypot(*(each[0] for each in swept)), size)
    assert max(each[1] for each in swept) > 1e5
    scene, _ = adjoints.double(1)
    scene = scene.replaced(scene.beams[1], n_elements="auto")
    with pytest.raises(ancf.PlanError, match="does not converge as meshes and steps are refined"):
        ancf.plan(scene, 10.0, ancf.position(scene.beams[1].end), "1 %")


def test_the_residual_of_the_richer_model_has_the_error_of_its_mesh_in_it():
    """Shear by the forces in sections is within a few per cent (test_neglected.py)."""
    shares = [one / true for true, one in (adjoints.compare_shear(0.1, n) for n in (8, 16, 64))]
    assert shares[0] < 0.7
    assert 0.95 < shares[2] < 1.05
