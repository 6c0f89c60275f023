"""The error budget on short runs, and what it says about hand-made data."""

import numpy as np
import pytest

from ancfsparse.problems import pendulum
from ancfsparse.solve import simulate
from benchmarks.accuracy.error_budget import DEFAULT, STUDY, Budget, Part, chart, error_budget


@pytest.fixture(scope="module")
def budget():
    models = ("Thin", "Thin, Biot", "L2T2")
    return error_budget(models, 5, 1e-3, 0.4, meshes=(10, 20), fine=40)


def power(curve):
    """Return by which power of the value the errors change."""
    x, y = [p.value for p in curve], [p.error for p in curve]
    return np.polyfit(np.log(x), np.log(y), 1)[0]


def test_every_part_falls_as_its_method_says(budget):
    for model in ("Thin", "Thin, Biot", "L2T2"):
        assert power(budget.curve("time step", model)[-4:]) == pytest.approx(2.0, abs=0.2)
        meshes = budget.curve("mesh", model)
        assert power(meshes) == pytest.approx(-4.0, abs=1.0)
        assert [p.value for p in meshes] == [5, 10, 20]
        tolerances = [p for p in budget.curve("solver", model) if p.known and p.value != DEFAULT]
        assert len(tolerances) >= 4
        assert tolerances[0].error > 1e2 * tolerances[-1].error


def test_choice_is_taken_from_each_curve(budget):
    chosen = budget.choice("Thin")
    assert list(chosen) == ["mesh", "time step", "solver", "model"]
    assert (chosen["mesh"].value, chosen["time step"].value) == (5, 1e-3)
    assert chosen["solver"].value == DEFAULT
    models = budget.curve("model", "Thin")
    assert chosen["model"].error == max(p.error for p in models)
    assert {p.value for p in models} == {"Thin, Biot", "L2T2"}


def test_distance_between_models_is_symmetric(budget):
    (a,) = (p for p in budget.curve("model", "Thin") if p.value == "L2T2")
    (b,) = (p for p in budget.curve("model", "L2T2") if p.value == "Thin")
    assert (a.error, a.uncertainty) == (b.error, b.uncertainty)
    assert a.known


def test_the_chart_can_be_read(budget, readable):
    readable(chart(budget))


def test_files(budget, run_result):
    written = run_result("accuracy error-budget", budget)
    assert set(written.data["references"]) == {"Thin", "Thin, Biot", "L2T2"}
    assert len(written.data["parts"]) == len(budget.parts)
    assert "L2T2" in written.out


def by_hand(**errors):
    values = {"mesh": 10, "time_step": 5e-4, "solver": DEFAULT, "model": "Thick"}
    parts = [
        Part(name.replace("_", " "), "Thin", value, errors[name], 1e-9)
        for name, value in values.items()
    ]
    return Budget(parts, 10, 5e-4, {"Thin": None}, {})


def test_findings_name_the_largest_part_whichever_it_is():
    mesh = by_hand(mesh=1e-2, time_step=1e-4, solver=1e-8, model=5e-4)
    assert mesh.findings() == [
        "Thin, 10 elements, dt = 0.0005 s: the mesh leaves 1.0e-02 m, 20 times the model"
    ]
    step = by_hand(mesh=1e-4, time_step=3e-2, solver=1e-3, model=5e-4)
    assert "the time step leaves 3.0e-02 m, 30 times the solver" in step.findings()[0]
    assert "| Thin | 1.0e-04 ± 1e-09 | 3.0e-02 ± 1e-09 |" in STUDY.region("error-budget", step)


def test_models_differ_by_the_stretch():
    apart = []
    for youngs_modulus in (1e8, 1e9):
        tips = []
        for element in ("l2t2", "thin"):
            scene, rod = pendulum(element, 40, youngs_modulus=youngs_modulus)
            tips.append(simulate(scene, 2.0, 5e-4, save_nodes=[rod.end]).position(rod.end))
        apart.append(np.linalg.norm(tips[0] - tips[1], axis=1).max())
    assert 7.0 < apart[0] / apart[1] < 14.0  # a tenth of the stretch, and the same shear
