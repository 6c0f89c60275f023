"""Describing a scene does no work that its records do not need."""

import itertools

import numpy as np

import ancfsparse as ancf
from ancfsparse import system_memory


def test_small_bodies_joints_and_loads_ask_neither_for_memory_nor_for_a_decomposition(monkeypatch):
    def refused(*arguments, **options):
        raise AssertionError("not needed")

    monkeypatch.setattr(system_memory, "available_memory", refused)
    monkeypatch.setattr(np.linalg, "matrix_rank", refused)
    scene = ancf.Scene((0.0, -9.81))
    section, material = ancf.Circle(0.01), ancf.Material(1e8, 4000.0)
    beams = [scene.add_beam("thin", (k, 0.0), (k + 1, 0.0), 2, section, material) for k in range(3)]
    scene.pin(beams[0].start)
    for one, other in itertools.pairwise(beams):
        scene.connect(one.end, other.start)
    scene.rod(beams[2].end, (3.0, 1.0))
    scene.point_force(beams[2].end, (0.0, 1.0))
    assert len(scene.records) == 8
