"""Axes beside the centroid, by rigid bodies at the ends of a beam, and calculations by hand."""

from __future__ import annotations

import numpy as np
import pytest

import ancfsparse as ancf

LENGTH, SIDE, OFF = 2.0, 0.05, 0.08
SECTION, STEEL = ancf.Rectangle(SIDE, SIDE), ancf.Material(2e11, 7800.0)
EA, EI = 2e11 * SIDE**2, 2e11 * SIDE**4 / 12.0


def offset_cantilever(n, element, dim, force):
    """A cantilever whose load acts on an axis that lies OFF above its centroid."""
    z = (0.0,) * (dim - 2)
    scene = ancf.Scene((0.0, 0.0, *z))
    rod = scene.add_beam(element, (0, 0, *z), (LENGTH, 0, *z), n, SECTION, STEEL)
    scene.clamp(rod.start)
    inertia = 1e-3 if dim == 2 else (1e-3, 1e-3, 1e-3)
    arm = scene.add_body(mass=1.0, inertia=inertia, position=(LENGTH, 0, *z))
    scene.weld(rod.end, arm.origin)
    scene.point_force(arm.at((0.0, OFF, *z)), (force, 0.0, *z))
    return ancf.solve_static(scene), rod, arm


@pytest.mark.parametrize(("element", "dim"), [("thin", 2), ("thick", 2), ("thick", 3)])
def test_an_axial_load_on_an_eccentric_axis_bends_and_stretches(element, dim):
    # With the tension F the deflection is e (1 / cosh(k L) - 1), k^2 = F / EI, for small forces
    # -F e L^2 / 2 EI; the loaded point moves by F L (1 / EA + e^2 / EI) to first order.
    force = 10.0
    down = OFF * (1.0 / np.cosh(LENGTH * np.sqrt(force / EI)) - 1.0)
    along = force * LENGTH * (1.0 / EA + OFF**2 / EI)
    errors = []
    for n in (4, 8):
        rest, rod, arm = offset_cantilever(n, element, dim, force)
        top = arm.at((0.0, OFF, *(0.0,) * (dim - 2)))
        errors.append(abs(rest.position(rod.end)[1] / down - 1.0))
        # Clamps of thick beams hold the height of the section, which is felt over an element.
        near = 3e-4 if element == "thin" else 2e-2 / n
        assert rest.position(top)[0] - LENGTH == pytest.approx(along, rel=near)
    assert errors[1] < 2e-7
    assert element == "thin" or errors[0] / errors[1] > 12.0  # order 4
    np.testing.assert_allclose(rest.section_force(rod, 0.5).N, force, rtol=1e-3)
