"""What may be attached, and what is refused in one sentence."""

import ctypes as ct
import pickle

import numpy as np
import pytest

import ancfsparse as ancf
from tests.pickling import leave_out_cloudpickle


def scene_of(dim=2, element="thin"):
    pad = (0.0,) * (dim - 2)
    scene = ancf.Scene((0.0, -9.81, *pad))
    section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0, 0.3)
    return scene, scene.add_beam(element, (0, 0, *pad), (1, 0, *pad), 2, section, material)


@pytest.mark.parametrize(
    ("attach", "message"),
    [
        (lambda s, b: s.add_mass(b.end, -1.0), "must not be negative, got -1 kg"),
        (lambda s, b: s.add_mass(b.end, 0.0), "is zero: give a mass or an inertia"),
        (lambda s, b: s.add_mass(b.at(0.3), 1.0, inertia=1.0), "needs a node"),
        (lambda s, b: s.add_mass(b.end, 1.0, inertia=-2.0), "must not be negative, got -2 kg m2"),
        (lambda s, b: s.add_mass("end", 1.0), "needs a point on a beam"),
        (lambda s, b: s.add_mass(scene_of()[1].end, 1.0), "of another scene"),
        (lambda s, b: s.force(np.array(1.0), lambda q, v, t: -v), "needs points of beams, got"),
        (lambda s, b: s.force(3, lambda q, v, t: -v), "needs points of beams, got 3"),
        (lambda s, b: s.spring(b.end, (1e200, 0), stiffness=1.0), r"lies beyond 1e\+150 m"),
        (lambda s, b: s.spring(b.start, b.end), "does nothing: give it a stiffness"),
        (lambda s, b: s.spring(b.end, b.end, stiffness=1.0), "both ends at one point"),
        (lambda s, b: s.spring(b.end, (1, 0), stiffness=1.0), "pass length="),
        (lambda s, b: s.spring(b.end, (1, 0, 0), stiffness=1.0), "the scene is planar"),
        (
            lambda s, b: s.spring(b.end, (2, 0), stiffness=-1.0),
            "stiffness .* must not be negative",
        ),
        (lambda s, b: s.spring(b.end, (2, 0), damping=np.nan), "damping of the spring .* finite"),
        (lambda s, b: s.spring(b.end, (2, 0), stiffness=lambda e: e / 0), "ZeroDivisionError"),
        (lambda s, b: s.spring(b.end, (2, 0), stiffness=lambda e: np.nan), "no finite number"),
        (lambda s, b: s.spring(b.end, (2, 0), stiffness=lambda e: "x"), "force law .* ValueError"),
        (lambda s, b: s.force([], lambda q, v, t: q), "at least one point"),
        (lambda s, b: s.force(b.end, 3.0), "must be a function of positions, velocities and time"),
        (lambda s, b: s.force([b.end, b.end], lambda q, v, t: q), "twice"),
        (lambda s, b: s.force(b.end, lambda q, v, t: q[0]), r"shape \(2,\), where \(1, 2\)"),
        (lambda s, b: s.force(b.end, lambda q, v, t: q * np.nan), "returned nan N along x"),
        (lambda s, b: s.force(b.end, lambda q: q), "TypeError"),
        (lambda s, b: s.force(b.end, lambda q, v, t: "x"), "not an array of numbers"),
    ],
)
def test_what_is_invalid_is_refused_at_once(attach, message):
    scene, beam = scene_of()
    with pytest.raises(ancf.InputError, match=message):
        attach(scene, beam)
    assert scene.attachments == []


@pytest.mark.parametrize(
    ("inertia", "message"),
    [
        ((1.0, 1.0, 3.0), "is not physical"),
        ((1.0, -1.0, 1.0), "is not physical"),
        ((1.0, 2.0), "3 principal moments or a 3 x 3 matrix"),
        (((1.0, 0.5, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), "must be symmetric"),
        ((1.0, np.inf, 1.0), "must be finite"),
    ],
)
def test_moments_that_no_body_has_are_refused(inertia, message):
    scene, beam = scene_of(3, "thick")
    with pytest.raises(ancf.InputError, match=message):
        scene.add_mass(beam.end, 1.0, inertia=inertia)


def test_a_cable_in_space_has_no_frame_for_a_rotary_inertia():
    scene, cable = scene_of(3)
    with pytest.raises(ancf.InputError, match=r"has no frame .* element='thick'"):
        scene.add_mass(cable.end, 1.0, inertia=(1.0, 1.0, 1.0))


def test_a_c_function_of_another_signature_is_refused():
    scipy = pytest.importorskip("scipy")
    scene, beam = scene_of()
    wrong = scipy.LowLevelCallable(ct.CFUNCTYPE(ct.c_int, ct.c_int)(lambda n: n))
    with pytest.raises(ancf.InputError, match=r"signature 'int \(int\)': it must be 'int \("):
        scene.force(beam.end, wrong)
    with pytest.raises(ancf.InputError, match=r"it must be 'double \(double\) or double \("):
        scene.spring(beam.end, (2, 0), stiffness=wrong)


def test_scenes_with_functions_can_be_sent(monkeypatch):
    leave_out_cloudpickle(monkeypatch)
    scene, beam = scene_of()
    scene.spring(beam.end, (2, 0), stiffness=lambda e: e)
    scene.force(beam.end, lambda q, v, t: -v)
    scene.add_mass(beam.end, 1.0)
    there = pickle.loads(pickle.dumps(scene))
    assert len(there.attachments) == 3
    with pytest.raises(ancf.InputError, match="was not sent along"):
        there.attachments[0].stiffness(1.0)
