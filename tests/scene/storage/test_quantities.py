"""Numbers with units: exact in decimal, compared with pint, and refused in other dimensions."""

import importlib.util
import math

import pytest

import ancfsparse as ancf
from ancfsparse.scene.records.record import RECORD_TYPES
from ancfsparse.scene.storage.json_file import DATA
from ancfsparse.scene.storage.named_parts import arguments_of
from ancfsparse.scene.storage.quantities import UNITS, parse_quantity, parse_unit

# Symbols that pint reads in another sense, with its own names for them.
NAMES_IN_PINT = {
    "rev": "turn",
    "-": "",
    "1": "",
    "h": "hour",
    "lb": "pound",
    "lbf": "force_pound",
    "t": "tonne",
}


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("7 mm", "m", 0.007),
        ("0.3 mm", "m", 0.0003),
        ("210 GPa", "Pa", 210e9),
        ("-9.81 m/s2", "m/s2", -9.81),
        ("4 cm4", "m4", 4e-8),
        ("1.5 N s/m", "N s/m", 1.5),
        ("1e3 kg/m^3", "kg/m3", 1e3),
        ("12.5 %", "-", 0.125),
        ("60 rpm", "rad/s", 2.0 * math.pi),
        ("90 deg", "rad", math.pi / 2.0),
        ("45 deg", "degrees", 45.0),
        ("1 h", "s", 3600.0),
        ("2 kN*m", "N m", 2000.0),
        ("3 1/s", "Hz", 3.0),
    ],
)
def test_numbers_are_the_nearest_to_those_in_si_units(text, unit, value):
    assert parse_quantity(text, (unit,)) == value


@pytest.mark.skipif(importlib.util.find_spec("pint") is None, reason="pint is not installed")
def test_units_are_those_of_pint():
    import pint

    registry = pint.UnitRegistry()
    for name, unit in UNITS.items():
        dimension = registry.Quantity(1, NAMES_IN_PINT.get(name, name)).to_base_units()
        # pint's base units are m, g, s, and its angles have no dimension.
        kg, m, s, _ = unit.dimension
        expected = registry.Quantity(1, f"kg^{kg} * m^{m} * s^{s}".replace("^", "**"))
        ratio = (dimension / expected).to_base_units()
        assert ratio.dimensionless, name
        assert float(ratio.magnitude) == pytest.approx(float(unit.factor), rel=1e-12), name


@pytest.mark.parametrize(
    ("text", "units", "message"),
    [
        ("2 mm", ("s",), "a unit such as s is needed, got '2 mm'"),
        ("10 Hz", ("rad/s",), "a unit such as rad/s is needed"),
        ("1 N", ("rad", "m"), "a unit such as rad or m is needed"),
        ("10 mmm", ("m",), "unknown unit 'mmm' in 'mmm': did you mean 'mm'"),
        ("10", ("m",), "'10' has no unit: write the number without quotes"),
        ("ten mm", ("m",), "a number is needed, or a number with a unit such as '10 mm'"),
        ("10 m", (), "this number has no unit, got '10 m'"),
        ("1e999 m", ("m",), "beyond the range of floating-point numbers"),
        ("9**9**9**9 m", ("m",), "unknown unit"),
        ("1 m^9^9", ("m",), "unknown unit"),
        ("1 N/m/s", ("m",), "unknown unit"),
        ("1 m/", ("m",), "ends in a slash"),
        ("__import__('os') m", ("m",), "a number is needed"),
        ("1" * 4000 + " m", ("m",), "unknown unit|a number is needed"),
    ],
)
def test_other_texts_are_refused(text, units, message):
    with pytest.raises(ancf.InputError, match=message):
        parse_quantity(text, units)


def test_every_number_of_a_scene_has_a_unit_or_none_on_purpose():
    """A parameter that is one number has a unit, or is listed here as a number without one."""
    without = {
        ("add_beam", "slack"), ("add_mesh", "slack"), ("Polygon", "shear_factor"),
        ("Section", "shear_factor"), ("Helix", "turns"), ("Material", "poisson_ratio"),
    }  # fmt: skip
    calls = {name: getattr(ancf.Scene, name) for name in RECORD_TYPES} | DATA
    missing = {
        (name, each.name)
        for name, call in calls.items()
        for each in arguments_of(call)
        if "float" in each.words and not each.words & {"Callable", "Sequence"} and not each.units
    }
    directions = {pair for pair in missing if pair[1] in ("axis", "normal", "towards")}
    assert missing - directions <= without


def test_units_of_records_and_of_docstrings_agree():
    for name, record in RECORD_TYPES.items():
        documented = {each.name: each.units for each in arguments_of(getattr(ancf.Scene, name))}
        for field, unit in record.units.items():
            assert unit in documented[field]
            parse_unit(unit)
