"""Environments of Gymnasium: its checker, repeatable episodes, a balanced pole, clear refusals."""

import numpy as np
import pytest

import ancfsparse as ancf
from tests.embedding.cart import DT, balance, cart_with_pole, observe

gymnasium = pytest.importorskip("gymnasium")
checker = pytest.importorskip("gymnasium.utils.env_checker")
SUBSTEPS = 10


def build(largest=20.0, **options):
    scene, push, cart, pole = cart_with_pole()
    return ancf.gym.make(
        scene,
        {push: ((-largest, 0.0), (largest, 0.0))},  # N, along the rail
        observe(cart, pole),
        lambda sim: -abs(sim.position(cart.origin)[0]),
        DT,
        SUBSTEPS,
        ends=lambda sim: sim.position(pole.end)[1] < 0.5,
        **options,
    )


def episode(environment, policy, seed=None):
    observation, _ = environment.reset(seed=seed)
    rows = [observation]
    while True:
        observation, reward, is_over, truncated, information = environment.step(policy(observation))
        rows.append(np.append(observation, reward)[:-1])
        if is_over or truncated:
            return np.array(rows), is_over, information


@pytest.mark.filterwarnings("ignore:.*normalized space")  # recommended for learning
def test_the_checker_of_gymnasium_passes():
    checker.check_env(build(bounds=(-100.0, 100.0)), skip_render_check=True)


def test_a_controller_balances_the_pole_that_falls_without_it():
    _, is_over, _ = episode(build(t_end=5.0), lambda observation: [0.0])
    assert is_over
    rows, is_over, _ = episode(build(t_end=10.0), balance)
    assert not is_over
    assert len(rows) == 10.0 / (SUBSTEPS * DT) + 1
    assert abs(rows[100, 0]) > 0.1  # m, the cart has moved below the pole
    np.testing.assert_allclose(rows[-1], [0.0, 0.0, 0.0, 1.0, 0.0], atol=2e-3)


def test_an_action_is_reached_at_the_end_of_the_step_of_the_environment():
    environment = build()
    environment.reset()
    environment.step([3.0])
    sim = environment.simulation
    assert sim.steps == SUBSTEPS
    np.testing.assert_allclose(sim.value(ancf.Input(2, name="push")), [3.0, 0.0], atol=1e-12)


def test_episodes_from_the_same_seed_are_equal_bit_for_bit():
    def begin(sim, random):
        sim.set(ancf.Input(2, name="push"), [random.normal(), 0.0])
        sim.step(5)

    environment = build(begin=begin, t_end=0.5)
    first, again, other = (episode(environment, balance, seed)[0] for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert np.any(first != other)


def test_environments_in_processes_equal_one_in_this_process():
    alone = build()
    start, _ = alone.reset()
    row = alone.step([2.0])[0]
    several = gymnasium.vector.AsyncVectorEnv([build, build])
    try:
        starts, _ = several.reset()
        rows = several.step(np.array([[2.0], [-2.0]]))[0]
    finally:
        several.close()
    np.testing.assert_array_equal(starts, [start, start])
    np.testing.assert_array_equal(rows[0], row)
    assert np.any(rows[1] != row)


def test_a_step_that_fails_truncates_the_episode_and_a_reset_begins_again():
    environment = build(largest=1e200)  # N
    observation, _ = environment.reset()
    _, _, _, truncated, information = environment.step([1e200])
    assert truncated
    assert "t = " in information["error"]
    np.testing.assert_array_equal(environment.reset()[0], observation)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"actions": {}}, "actions must name inputs with their limits"),
        ({"actions": {ancf.Input(name="wind"): (0, 1)}}, "not an input of this scene"),
        ({"limits": ((1.0, 0.0), (0.0, 0.0))}, "lower limit of push must not exceed"),
        ({"limits": ((np.nan, 0.0), (0.0, 0.0))}, "limits of push"),
        ({"observations": []}, "observations must have a function"),
        ({"reward": 1.0}, "reward must be functions"),
        ({"substeps": 0}, "substeps"),
        ({"t_end": -1.0}, "t_end"),
        ({"bounds": ([0, 0], [1, 1])}, "one for each number that is observed"),
    ],
)
def test_bad_input_is_refused(changes, message):
    scene, push, cart, _ = cart_with_pole()
    arguments = {
        "actions": {push: changes.pop("limits", ((-1.0, 0.0), (1.0, 0.0)))},
        "observations": [lambda sim: sim.position(cart.origin)[0]],
        "reward": lambda sim: 0.0,
        "dt": DT,
    } | changes
    with pytest.raises(ancf.InputError, match=message):
        ancf.gym.make(scene, **arguments)


@pytest.mark.parametrize("action", [[np.nan], [1.0, 2.0], 1.0])
def test_an_action_of_another_shape_or_without_value_is_refused(action):
    environment = build()
    environment.reset()
    with pytest.raises(ancf.InputError, match="an action must be 1 finite numbers"):
        environment.step(action)
