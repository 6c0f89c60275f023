"""Records: a scene is a list of what was specified, from which it can be built again."""

import inspect
from dataclasses import fields

import pytest

import ancfsparse as ancf
from ancfsparse.scene.records.record import RECORD_TYPES
from tests.scene.everything import everything

OWN = {
    name: each for name, each in RECORD_TYPES.items() if each.__module__.startswith("ancfsparse.")
}


def test_there_is_a_scene_with_every_record():
    assert {each.method for each in everything().records} == set(OWN)


@pytest.mark.parametrize("method", OWN)
def test_a_record_has_the_parameters_of_its_method(method):
    taken = inspect.signature(getattr(ancf.Scene, method)).parameters
    usual = {name: each.default for name, each in taken.items() if name != "self"}
    assert {each.name for each in fields(RECORD_TYPES[method])} == set(usual)
    assert set(RECORD_TYPES[method].units) <= set(usual)


def test_records_are_equal_if_all_that_was_specified_is():
    one, other = everything().records, everything().records
    assert one == other
    for k, record in enumerate(one):
        assert all((record == each) == (i == k) for i, each in enumerate(other))
