"""FMUs: FMPy finds them valid and runs them as a Simulation runs the scene; refusals."""

import numpy as np
import pytest

import ancfsparse as ancf
from tests.solve.refusals import assert_refused

fmpy = pytest.importorskip("fmpy")
pytest.importorskip("pythonfmu3")
validation = pytest.importorskip("fmpy.validation")

DT, H = 2e-3, 1e-2  # s, time step and communication step
T_END = 0.3


def build(first_wind=0.0):
    """Return a scene of a load on a winch and on a cable, its inputs and its outputs."""
    length = ancf.Input(default=2.0, name="length")
    wind = ancf.Input(3, default=first_wind, name="wind")
    scene = ancf.Scene((0, 0, -9.81))
    load = scene.add_body(ancf.Sphere(0.1), mass=5.0, position=(0, 0, -2))
    cable = scene.add_beam(
        "thin", (0, 0, -2), (0.5, 0, -2.2), 4, ancf.Circle(0.01), ancf.Material(1e8, 1e3)
    )
    winch = scene.winch([(0, 0, 0), load.origin], length=length)
    joint = scene.connect(cable.start, load.origin)
    rope = scene.rope([(1, 0, -1), cable.at(0.3)], stiffness=100.0)
    scene.point_force(cable.end, wind)
    outputs = {
        "load": ("position", load.origin),
        "tip": ("velocity", cable.at(0.4)),
        "lift": ("tension", winch),
        "guy": ("tension", rope),
        "pull": ("joint_force", joint),
        "acceleration": ("acceleration", cable.end),
    }
    return scene, length, wind, outputs


def wind_at(t):
    return np.array([0.3 * np.sin(20 * t), 0.2 * t, 0.1])


def length_at(t):
    return 2.0 - 0.1 * t - 0.05 * np.sin(10 * t), -0.1 - 0.5 * np.cos(10 * t)


def read(sim, what, handle):
    value = getattr(sim, what)(handle)
    return np.ravel(value.force if what == "joint_force" else value)


@pytest.fixture
def fmu(tmp_path):
    scene, length, wind, outputs = build()
    return ancf.fmu.write(
        tmp_path / "winch 1.fmu",
        scene,
        inputs=[length, wind],
        rates=[length],
        outputs=outputs,
        dt=DT,
        integrator=ancf.GeneralizedAlpha(0.8),
    )


def test_the_validator_finds_nothing(fmu):
    assert fmu.name == "winch 1.fmu"
    assert validation.validate_fmu(str(fmu)) == []
    description = fmpy.read_model_description(str(fmu))
    units = {each.name: each.unit for each in description.modelVariables}
    assert units["wind.x"] is None
    assert units["load.z"] == units["load.x"] == "m"
    assert units["tip.y"], units["guy"] == ("m/s", "N")
    assert description.defaultExperiment.stepSize == str(DT)


def test_a_run_of_the_fmu_equals_a_simulation_to_rounding(fmu):
    times = np.arange(0.0, T_END + H / 2, H)
    columns = {
        "time": times,
        **dict(zip(("length", "length_rate"), length_at(times), strict=True)),
        **{f"wind.{axis}": [wind_at(t)[k] for t in times] for k, axis in enumerate("xyz")},
    }
    inputs = np.zeros(len(times), [(name, float) for name in columns])
    for name, values in columns.items():
        inputs[name] = values
    table = fmpy.simulate_fmu(
        str(fmu), stop_time=T_END, step_size=H, output_interval=H, input=inputs
    )

    scene, length, wind, outputs = build(wind_at(0.0))
    sim = ancf.Simulation(scene, DT, integrator=ancf.GeneralizedAlpha(0.8))
    rows = []
    for t in times:
        rows.append(np.concatenate([read(sim, *each) for each in outputs.values()]))
        value, rate = length_at(t)
        sim.set(length, value, rate=rate, over=H)
        sim.set(wind, wind_at(t), over=H)
        sim.step(round(H / DT))
    names = [name for name in table.dtype.names if name != "time"]
    assert names[:4] == ["load.x", "load.y", "load.z", "tip.x"]
    result = np.array([table[name] for name in names]).T
    np.testing.assert_allclose(table["time"], times, atol=1e-12)
    np.testing.assert_allclose(result, rows, rtol=1e-12, atol=1e-12)
    assert np.ptp(result[:, 2]) > 0.02  # m, the load rises


def test_a_communication_step_must_be_a_number_of_time_steps(fmu, capfd):
    with pytest.raises(fmpy.fmi1.FMICallException, match="fmi3DoStep"):
        fmpy.simulate_fmu(str(fmu), stop_time=9e-3, step_size=3e-3, output_interval=3e-3)
    assert "must be a number of steps of 0.002 s" in capfd.readouterr().out


def test_two_fmus_run_in_one_process_and_start_again(tmp_path):
    """Each has a scene of its own, and every run begins with the values of its initialization."""
    for height in (1.0, 2.0):
        scene = ancf.Scene((0, -9.81))
        push = ancf.Input(2, default=(1.0, 0.0), name="push")
        body = scene.add_body(ancf.Sphere(0.1), mass=2.0, position=(0, height))
        scene.point_force(body.origin, push)
        file = ancf.fmu.write(
            tmp_path / f"{height:.0f}.fmu", scene, inputs=[push],
            outputs={"place": ("position", body.origin)}, dt=1e-3,
        )  # fmt: skip
        for start in ({}, {}, {"push.x": 3.0}):
            table = fmpy.simulate_fmu(
                str(file), stop_time=0.1, step_size=0.1, output_interval=0.1, start_values=start
            )
            expected = (start.get("push.x", 1.0) / 2 * 0.005, height - 9.81 * 0.005)
            np.testing.assert_allclose(
                [table["place.x"][-1], table["place.y"][-1]], expected, atol=1e-6
            )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"path": "scene.zip"}, "must end in .fmu"),
        ({"scene": 1}, "a Scene is needed"),
        ({"dt": -1.0}, "dt"),
        ({"inputs": 1.0}, "inputs must be a list of Input"),
        ({"inputs": [ancf.Input(name="gust")]}, "not an input of this scene"),
        ({"rates": [ancf.Input(3, name="wind")]}, "wind has a rate and is not among the inputs"),
        ({"outputs": {}}, "outputs must name results"),
        ({"outputs": {"tip": "position"}}, "output tip must be a result and its handle"),
        ({"outputs": {"tip": ("positon", None)}}, "did you mean 'position'"),
        ({"outputs": {"tip": ("position", None)}}, "None"),
        ({"outputs": {"tip of it": "tip"}}, "such as 'push', got 'tip of it'"),
        ({"outputs": {"time": "tip"}}, "two variables of the FMU are named 'time'"),
        ({"integrator": "heun"}, "integrator"),
    ],
)
def test_bad_input_is_refused(tmp_path, monkeypatch, changes, message):
    monkeypatch.chdir(tmp_path)
    scene, _, _, outputs = build()
    arguments = {"path": "winch.fmu", "scene": scene, "outputs": outputs, "dt": DT} | changes
    arguments["outputs"] = {
        name: outputs["tip"] if result == "tip" else result
        for name, result in arguments["outputs"].items()
    }
    assert_refused(message, ancf.fmu.write, **arguments)


def test_scenes_with_functions_are_refused(tmp_path):
    scene = ancf.Scene((0, -9.81))
    body = scene.add_body(ancf.Sphere(0.1), mass=2.0, position=(0, 0))
    scene.point_force(body.origin, wind_of_a_function)
    outputs = {"place": ("position", body.origin)}
    assert_refused(
        "an FMU cannot contain this scene: .*wind_of_a_function",
        ancf.fmu.write, tmp_path / "a.fmu", scene, outputs=outputs, dt=DT,
    )  # fmt: skip


def wind_of_a_function(t):
    return (np.sin(t), 0.0)
