"""The study of values next to their references, on quick checks, and the formulas that it has."""

import math

import numpy as np
import pytest

from ancfsparse.errors import InputError
from benchmarks.contact import reference_values as study
from benchmarks.contact.references import belts, capstans, comparison, knots, obstacles, piles


def fail():
    raise InputError("the scene is wrong")


@pytest.fixture
def written(run_study, monkeypatch):
    checks = {
        "quick": {"block": obstacles.compare_block, "cantilever": obstacles.compare_cantilever},
        "long": {"wrong": fail},
    }
    monkeypatch.setattr(study, "CHECKS", checks)
    return lambda *options: run_study("contact references", *options)


def test_values_are_set_next_to_their_references(written):
    result = written()
    assert [each["check"] for each in result.table] == ["block"] * 2 + ["cantilever"] * 3
    distance = result.table[1]
    assert float(distance["value"]) == pytest.approx(1.529052, rel=1e-4)
    assert (distance["reference"], distance["tolerance"]) == ("1.529052", "0.01 %")
    assert [each["met"] for each in result.table] == ["True"] * 4 + ["False"]
    assert (
        "| block, Coulomb's law: distance [m] | 1.52917 | 1.52905 | 0.01 % | yes |" in result.page
    )
    assert "| -0.48427 | 0.1 % | not met |" in result.page
    assert "- 4 of 5 values are within their tolerances." in result.page
    assert "Not met: cantilever on cylinders, Exudyn's test" in result.out


def test_a_run_that_fails_is_a_value_outside_of_all_bounds(written):
    result = written("--part", "all")
    assert [each["met"] for each in result.table] == ["True"] * 4 + ["False"] * 2
    assert result.data["rows"][-1]["value"] is None
    assert "| wrong: a run fails | nan | nan | 0 | not met |" in result.page
    assert "wrong fails: the scene is wrong" in result.out


def test_only_values_between_bounds_are_met():
    for value, is_met in ((0.99, True), (0.98, False), (math.nan, False), (math.inf, False)):
        assert comparison.compare_relative("", value, 1.0, 0.015).is_met == is_met
        assert comparison.compare_absolute("", -value, -1.0, 0.015).is_met == is_met
        assert comparison.limit_below("", value, 0.985).is_met == (is_met or value == math.inf)
        assert comparison.limit_above("", -value, -0.985).is_met == (is_met or value == math.inf)


def test_values_of_the_machine_have_no_verdict():
    rows = [comparison.state_value("time", 3.0), comparison.limit_above("depth", 2.0, 1.0)]
    results = [study.CheckResult("pile", rows, 1.0)]
    assert study.value_table(results).rows[0] == ["time", "3", "", "", ""]
    assert [each["met"] for each in study.records(results)] == [None, False]
    assert study.findings(results)[0].startswith("0 of 1 values")


def test_the_theory_of_belts_has_the_numbers_of_independent_solutions():
    """Also at a low speed, where the centrifugal force vanishes, and at full slip."""
    found = belts.BeltTheory(lambda _: 10.0).solve()
    np.testing.assert_allclose(found, (251.2362, 151.1875, 99.505962, 102.1734), rtol=1e-6)
    slow = belts.BeltTheory(lambda _: 10.0, omega=1.0).solve()
    assert 1.0 - slow[2] == pytest.approx(4.93800e-3, rel=1e-5)
    assert slow[3] == pytest.approx(97.0023, rel=1e-6)
    limit = belts.BeltTheory(lambda _: belts.SLIP_MOMENT).solve()
    np.testing.assert_allclose(limit[:2], (292.4026, 119.8696), rtol=1e-6)
    assert limit[3] == pytest.approx(180.0, abs=1e-3)
    published = belts.PUBLISHED.solve()
    np.testing.assert_allclose(published, (663.2, 186.9, 11.308, 145.6), rtol=4e-4)


def test_a_stiff_wire_has_the_ratio_of_an_independent_solution():
    assert capstans.lift_off_ratio(0.3, math.pi, 1e-3, 0.1) == pytest.approx(2.558141, abs=1e-6)
    assert capstans.lift_off_ratio(0.3, math.pi, 4e-3, 0.1) == pytest.approx(2.534932, abs=1e-6)
    s = math.log(capstans.CREEP_LOAD) / (0.3 * math.pi)
    assert pytest.approx(1e-3 * s / math.sqrt(1.0 - s**2), rel=1e-5) == capstans.CREEP


def test_the_determinant_tells_knots_from_loops():
    t = np.linspace(-2.3, 2.3, 400)
    trefoil = np.stack([t**3 - 3.0 * t, t**4 - 4.0 * t**2, t**5 - 10.0 * t], axis=1)
    figure_eight = np.stack(
        [t**3 - 3.0 * t, t * (t**2 - 1.0) * (t**2 - 4.0), t**7 - 42.0 * t], axis=1
    )
    loop = np.stack([t**3 - 3.0 * t, -(t**2), 0.1 * t], axis=1)
    assert knots.compute_determinant(trefoil) == 3
    assert knots.compute_determinant(loop) == 1
    assert knots.compute_determinant(loop[:3]) == 1
    assert knots.compute_determinant(figure_eight) == 5


def test_the_weights_of_pile_and_net_are_those_of_their_scenes():
    scene = piles.pile(3, 0.4).scene
    length = scene.beams[0].lengths.sum()
    assert length == pytest.approx(1.2, rel=1e-4)
    net = piles.net_on_sphere(piles.NET_SIZE).scene
    mass = net.beams[0].lengths.sum() * math.pi * 4e-6 * 1000.0
    assert mass == pytest.approx(piles.NET_MASS)
