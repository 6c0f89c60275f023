"""The table of thresholds: one constant changed at a time, and restored."""

from importlib import import_module

from ancfsparse.plans.discretization_error import error_model, run_series
from benchmarks.economy import thresholds as module


def test_a_changed_threshold_changes_plans_and_is_restored(monkeypatch):
    monkeypatch.setattr(module, "CASES", {name: module.CASES[name] for name in ("deflection",)})
    whole, strict = module.thresholds(["SAFETY_FRACTION"])
    assert (whole.changed, whole.work, whole.exceeded) == (0, 1.0, 0)
    assert whole.met == 2
    assert strict.threshold == "SAFETY_FRACTION"
    assert error_model.SAFETY_FRACTION == run_series.SAFETY_FRACTION == 0.75


def test_a_constant_is_changed_where_it_was_imported():
    with module._changed("discretization_error.error_model", "SAFETY_FRACTION", 0.1):
        assert error_model.SAFETY_FRACTION == run_series.SAFETY_FRACTION == 0.1
    assert error_model.SAFETY_FRACTION == run_series.SAFETY_FRACTION == 0.75


def test_every_listed_threshold_exists():
    for name, constant, value in module.WITHOUT:
        present = getattr(import_module(module.PACKAGE + name), constant)
        with module._changed(name, constant, value):
            assert getattr(import_module(module.PACKAGE + name), constant) == value
        assert getattr(import_module(module.PACKAGE + name), constant) is present
