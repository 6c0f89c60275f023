"""A shape that is defined outside the package is a section like the others."""

from dataclasses import dataclass

import pytest

import ancfsparse as ancf
from ancfsparse.scene.sections.cross_section import SECTION_TYPES, CrossSection


@pytest.fixture
def ellipse():
    @dataclass(frozen=True)
    class Ellipse(CrossSection):
        width: float
        height: float
        noun = "ellipse"
        sides = ("width", "height")
        shear_factor = 0.9

        area = property(lambda self: 0.7853981633974483 * self.width * self.height)
        inertia_y = property(lambda self: self.area * self.width**2 / 16.0)
        inertia_z = property(lambda self: self.area * self.height**2 / 16.0)
        torsion_constant = property(
            lambda self: 4.0 * self.inertia_y * self.inertia_z / (self.inertia_y + self.inertia_z)
        )

    yield Ellipse
    del SECTION_TYPES["Ellipse"]


def test_a_beam_has_a_registered_shape(ellipse, tmp_path):
    steel = ancf.Material(2e11, 7800.0)
    sags = []
    for section in (ellipse(0.01, 0.01), ancf.Circle(0.01)):
        scene = ancf.Scene(gravity=(0.0, -9.81))
        beam = scene.add_beam("thin", (0, 0), (1, 0), 4, section, steel)
        scene.clamp(beam.start)
        sags.append(ancf.solve_static(scene).position(beam.end)[1])
    assert sags[0] == pytest.approx(sags[1], rel=1e-12)
    with pytest.raises(ancf.InputError, match="Circle, Ellipse, IBeam"):
        scene.add_beam("thin", (0, 1), (1, 1), 4, "round", steel)
    with pytest.raises(ancf.InputError, match="height of the ellipse"):
        ellipse(0.01, -1.0)
