"""Invalid arguments are refused with a sentence, before anything is computed."""

import math
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.integrators.interface.time_grid import count_steps
from ancfsparse.problems import pendulum
from tests.beams import build_beam


def simulate(t_end=0.1, dt=1e-3, **options):
    scene, _ = pendulum("l2t2", 2)
    return ancf.simulate(scene, t_end, dt, **options)


@pytest.mark.parametrize(
    ("t_end", "dt", "message"),
    [
        (1.0, 0.0, "dt must be positive, got 0 s"),
        (1.0, math.nan, "dt must be finite, got nan s"),
        (-1.0, 1e-3, "t_end must be positive, got -1 s"),
        (math.inf, 1e-3, "t_end must be finite"),
        ("one", 1e-3, "t_end must be a number, got 'one'"),
        (5e-324, 5e-324, "t_end must be at least 1e-150 s, whose square"),
        (1e308, 1e306, "dt must be at most 1e+150 s"),
        (1.0, None, "needs a time step or an accuracy"),
        (1.0, 3e-3, "does not divide t_end = 1 s"),
        (1.0, 2.0, "dt = 2 s is longer than the run, t_end = 1 s: try dt = 0.1 s"),
        (np.float64(0.009), 4e-4, "try t_end = 0.0088 s, or dt = 0.000409090909 s"),
        (2.0, 3e-4, "try t_end = 2.0001 s, or dt = 0.000299985001 s"),
        (1.0, 0.4, "try t_end = 0.8 s, or dt = 0.5 s"),
    ],
)
def test_times(t_end, dt, message):
    with pytest.raises(ancf.InputError) as caught:
        simulate(t_end, dt)
    assert message in str(caught.value)


@pytest.mark.parametrize(("t_end", "dt"), [(0.3, 0.1), (0.1, 1e-3), (2.1, 7e-4), (1 / 3, 1 / 3000)])
def test_rounding_is_no_reason_to_refuse(t_end, dt):
    assert simulate(t_end, dt, solver=ancf.Newton()).stats.steps == round(t_end / dt)


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64])
def test_a_time_in_single_precision_is_the_decimal_that_it_shows(kind):
    run = simulate(0.01, kind(1e-3))
    assert run.stats.steps == 10
    assert run.t[-1] == 0.01


def test_more_steps_between_saved_states_than_there_are():
    run = simulate(0.01, 1e-3, save_every=10**30)
    np.testing.assert_allclose(run.t, [0.0, 0.01])


@pytest.mark.parametrize("t_end", [1.0, 0.7, 3.0])
def test_what_it_suggests_works(t_end):
    for n in range(2, 60):
        with pytest.raises(ancf.InputError) as caught:
            count_steps(t_end, t_end / (n + 0.3))
        message = str(caught.value)
        assert count_steps(t_end, float(message.split("or dt = ")[1].split(" s")[0])) == n
        end = float(message.split("try t_end = ")[1].split(" s")[0])
        assert count_steps(end, t_end / (n + 0.3)) == n


@pytest.mark.parametrize(("t_end", "dt"), [(1e300, 1e-20), (1e308, 1e-10), (1e3, 1e-14)])
def test_more_steps_than_can_be_counted(t_end, dt):
    with pytest.raises(ancf.InputError, match="take a larger dt"):
        simulate(t_end, dt)


def test_more_states_than_fit():
    with pytest.raises(ancf.InputError, match=r"need .* GB, more than there is: .* save_every"):
        simulate(1e3, 1e-10)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ancf.QuasiNewton("davidson"), "unknown update 'davidson': did you mean 'davidon'"),
        (lambda: ancf.QuasiNewton("sr1"), "valid are 'broyden', 'davidon', 'dfp', 'bfgs'"),
        (lambda: ancf.QuasiNewton("bfgs", memory="fulll"), "did you mean 'full'"),
        (lambda: ancf.QuasiNewton("bfgs", memory=0), "at least 1"),
        (lambda: ancf.QuasiNewton("bfgs", memory=2.5), "must be an integer"),
        (lambda: ancf.QuasiNewton("bfgs", seed="tangents"), "did you mean 'tangent'"),
        (lambda: ancf.QuasiNewton("bfgs", 10, seed="finite-difference"), "memory='full'"),
        (lambda: ancf.QuasiNewton("bfgs", max_iterations=0), "at least 1"),
        (lambda: ancf.QuasiNewton("bfgs", 10, carry="no"), "carry must be True or False, got 'no'"),
        (lambda: ancf.QuasiNewton("bfgs", memory=np.array([1, 2])), "must be an integer, got"),
        (lambda: ancf.QuasiNewton(np.array(["bfgs", "dfp"])), "unknown update array"),
        (lambda: ancf.RungeKuttaNystrom(np.array([4, 8])), "order 4 or 8, got array([4, 8])"),
        (lambda: ancf.RungeKuttaNystrom(5), "order 4 or 8, got 5"),
        (lambda: ancf.Newton(max_iterations=0), "at least 1"),
        (lambda: ancf.ModifiedNewton(max_iterations="many"), "must be an integer"),
    ],
)
def test_solvers(make, message):
    with pytest.raises(ancf.InputError) as caught:
        make()
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"solver": "newton"}, "got 'newton': did you mean Newton()?"),
        ({"solver": "Davidon"}, "got 'Davidon': did you mean QuasiNewton('davidon')?"),
        ({"solver": "foo"}, "'auto', Newton(), ModifiedNewton() or QuasiNewton(...), got 'foo'"),
        ({"solver": "automatic"}, "did you mean 'auto'"),
        ({"max_halvings": 1, "accuracy": 1e-3}, "leave out max_halvings=1"),
        ({"max_halvings": 1, "integrator": ancf.CentralDifference()}, "max_halvings=1 does"),
        ({"accuracy": 1e9}, "exceeds the size of the scene (2 m): use a smaller value"),
        ({"solver": ancf.Newton}, "solver must be 'auto', Newton(), "),
        ({"solver": None}, "solver must be 'auto'"),
        ({"solver": np.zeros(2)}, "solver must be 'auto'"),
        ({"tolerance": np.zeros(2)}, "tolerance must be a number, got array"),
        ({"max_energy_gain": np.zeros(2)}, "max_energy_gain must be a number, got array"),
        ({"max_energy_gain": -0.1}, "max_energy_gain must not be negative, got -0.1"),
        ({"progress": "no"}, "progress must be True or False, got 'no'"),
        ({"integrator": np.zeros(2)}, "integrator must be Newmark(alpha)"),
        ({"dt": 5e-324, "accuracy": 1e-3}, "dt must be at least 1e-150 s"),
        ({"integrator": "newmark"}, "integrator must be Newmark(alpha)"),
        ({"tolerance": "papers"}, "tolerance must be 'default', 'paper' or a number"),
        ({"tolerance": 0.0}, "tolerance must be positive"),
        ({"tolerance": math.nan}, "tolerance must be finite"),
        ({"tolerance": None}, "tolerance must be"),
        ({"save_every": 0}, "save_every must be an integer of at least 1"),
        ({"save_every": 1.5}, "save_every must be an integer"),
    ],
)
def test_settings(options, message):
    with pytest.raises(ancf.InputError) as caught:
        simulate(**options)
    assert message in str(caught.value)


def test_a_dense_inverse_that_is_too_large_is_refused_with_its_size():
    scene, _ = pendulum("l2t2", 1500)
    with pytest.raises(ancf.InputError) as caught:
        ancf.simulate(scene, 1e-3, 1e-3, solver=ancf.QuasiNewton("bfgs"))
    # 4 coordinates for each of 1501 nodes, less the pin: 6002^2 numbers of 8 bytes.
    assert "6002 x 6002" in str(caught.value)
    assert "0.288 GB" in str(caught.value)
    assert "memory=10" in str(caught.value)
    run = ancf.simulate(scene, 1e-3, 1e-3, solver=ancf.QuasiNewton("bfgs", memory=10))
    assert run.stats.steps == 1


@pytest.mark.parametrize("scene", [None, "net", pendulum("l2t2", 2).rod])
def test_what_is_no_scene_is_refused(scene):
    with pytest.raises(ancf.InputError, match="a Scene is needed, got"):
        ancf.simulate(scene, 1.0, 1e-3)


def test_problems_know_their_options():
    with pytest.raises(ancf.InputError, match="unknown option of a problem 'young'"):
        pendulum(young=1)


def test_a_scene_without_beams_is_refused():
    with pytest.raises(ancf.InputError, match="no beam: add one"):
        ancf.simulate(ancf.Scene(), 1.0, 1e-3)


SECTION, MATERIAL = ancf.Circle(0.01), ancf.Material(1e8, 1000.0)


def test_a_velocity_at_a_pin_is_refused():
    scene, _ = build_beam("thin", (0, 0), (1, 0), 2, SECTION, MATERIAL, "pin", velocity=(0, 2.5))
    with pytest.raises(
        ancf.InputError,
        match=r"moves 1 held coordinate, of the position of beam 0 at s = 0 m by 2.5 m/s: give",
    ):
        ancf.simulate(scene, 1.0, 1e-3)


@pytest.mark.parametrize("n_elements", [1, 2, 5])
def test_a_wave_between_pins_is_no_velocity_of_the_pins(n_elements):
    # Where both nodes of a single element are pinned, no node says how large rounding is.
    section, material = ancf.Circle(0.01), ancf.Material(1e7, 1e3)

    def wave(x):
        return np.outer(np.sin(3 * np.pi * x[:, 0] / 0.7), (0.0, 2.0))

    scene, _ = build_beam(
        "thin", (0, 0), (0.7, 0), n_elements, section, material, "pin", "pin", velocity=wave
    )
    assert ancf.simulate(scene, 1e-3, 1e-3).stats.steps == 1


@pytest.mark.parametrize("value", [(math.nan, 0.0), (1.0, math.inf), (1.0, 2.0, 3.0), "down"])
def test_a_load_that_goes_bad_on_the_way_says_when(value):
    scene, rod = pendulum("l2t2", 2)
    scene.point_force(rod.end, lambda t: (1.0, 0.0) if t < 0.05 else value)
    with pytest.raises(ancf.LoadError, match=r"at t = 0\.05"):
        ancf.simulate(scene, 0.1, 1e-3)


@pytest.mark.parametrize("what", ["position", "velocity", "acceleration", "slope", "reaction"])
def test_results_ask_for_points(what):
    run = simulate()
    for wrong in (3, "end", run.system.scene.beams[0]):
        with pytest.raises(ancf.InputError, match=r"needs a point on a beam such as rod\.start"):
            getattr(run, what)(wrong)


def test_reactions_are_those_of_nodes():
    run = simulate()
    with pytest.raises(ancf.InputError, match=r"a reaction needs a node, but .* lies inside elem"):
        run.reaction(run.system.scene.beams[0].at(0.1))


def test_decimals_and_fractions_are_numbers():
    scene, _ = pendulum("l2t2", 2)
    options = {"tolerance": Fraction(1, 1000), "max_energy_gain": Decimal("0.01")}
    one = ancf.simulate(scene, Decimal("0.01"), np.array(1e-3), **options)
    np.testing.assert_array_equal(one.q, simulate(0.01, 1e-3, tolerance=1e-3).q)
    ancf.simulate(scene, 0.01, accuracy=Decimal("0.001"))
    assert ancf.Simulation(scene, dt=Decimal("0.001")).dt == 1e-3
    assert ancf.Simulation(scene, dt=Fraction(1, 1000)).dt == 1e-3
    assert ancf.Newmark(Fraction(1, 4)) == ancf.Newmark(0.25)
    with pytest.raises(ancf.InputError, match="tolerance"):
        ancf.solve_static(scene, tolerance=Fraction(2))


def test_forces_inside_connections_are_not_given():
    scene, rod = pendulum("l2t2", 2)
    more = scene.add_beam("l2t2", rod.end.position, (4, 0), 2, rod.section, rod.material)
    scene.connect(rod.end, more.start)
    run = ancf.simulate(scene, 0.01, 1e-3)
    for node in (rod.end, more.start):
        with pytest.raises(ancf.InputError, match="held by connections alone, and forces inside"):
            run.reaction(node)
    with pytest.raises(ancf.InputError, match="no joint holds"):
        run.reaction(more.end)


def test_results_ask_for_nodes_of_their_own_scene():
    run = simulate()
    _, other = pendulum("l2t2", 2)
    with pytest.raises(ancf.InputError, match="not part of this scene"):
        run.position(other.end)


def test_a_blow_up_is_a_step_failure_and_no_warning():
    # Nothing of NumPy's or C's complaints reaches the caller, only the error.  Under 1e30 N the rod
    # is stretched to 1.2e9 m, which the last attempt by damped Newton finds.
    scene, rod = pendulum("l2t2", 2)
    scene.point_force(rod.end, lambda t: (0.0, 1e200 if t > 0.01 else 0.0))
    with pytest.raises(ancf.StepError) as caught:
        ancf.simulate(scene, 0.1, 1e-3, solver=ancf.QuasiNewton("bfgs"))
    assert caught.value.trajectory.stats.steps == caught.value.step - 1
    assert np.isfinite(caught.value.trajectory.q).all()


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.CentralDifference()])
@pytest.mark.parametrize(
    ("force", "velocity", "message"),
    [
        ((0.0, 1e308), None, r"where the force at beam 0, node 2, r_2 is 1e\+308 N: check the uni"),
        (lambda t: (-1e308, 0.0), None, r"where the force at beam 0, node 2, r_1 is -1e\+308 N"),
        (
            (0.0, 0.0),
            lambda x: 1e200 * x,
            r"where the speed of beam 0, node \d, r_x1 is 1e\+200 1/s",
        ),
    ],
)
def test_a_start_beyond_the_range_of_numbers_is_refused(integrator, force, velocity, message):
    scene, rod = build_beam("thin", (0, 0), (1, 0), 2, SECTION, MATERIAL, "pin", velocity=velocity)
    scene.point_force(rod.end, force)
    with pytest.raises(ancf.InputError, match=message):
        ancf.simulate(scene, 1e-3, 1e-5, integrator=integrator)


def test_constraints_that_need_an_infinite_acceleration_are_refused():
    scene, rod = build_beam("thin", (0, 0), (1, 0), 2, SECTION, MATERIAL, velocity=(3e154, 0.0))
    scene.rod(rod.start, (0.0, 1.0))
    with pytest.raises(ancf.InputError, match=r"where the rod at beam 0 at s = 0 m would need an "):
        ancf.simulate(scene, 1e-3, 1e-5)


def test_frequencies_in_the_range_of_numbers():
    scene = ancf.Scene((0.0, -9.81))
    section, material = ancf.Circle(0.02), ancf.Material(1e7, 1e3)
    scene.add_mesh([(0.0, 0.0), (1e-90, 0.0)], [(0, 1)], "thin", section, material)
    with pytest.raises(ancf.InputError, match=r"mesh 0, node 0, .* has a stiffness of"):
        ancf.simulate(scene, 2e-3, 1e-3)
