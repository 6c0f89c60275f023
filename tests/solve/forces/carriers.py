"""Bars and cables that carry masses, springs and forces, or are driven; shared by tests."""

import ancfsparse as ancf
from tests.beams import build_beam

# Of a beam that only carries masses and springs, its mass and stiffness beside theirs.
NOTHING = 1e-14


def carrier(n_elements, length, *, mass=NOTHING, stiffness=NOTHING, velocity=None, gravity=0.0):
    """A beam along x of so many kilograms, and so many newtons per metre of each element."""
    scene = ancf.Scene(gravity=(0.0, gravity))
    area = 1e-4
    material = ancf.Material(stiffness * length / n_elements / area, mass / (length * area))
    beam = scene.add_beam(
        "l2t2",
        (0, 0),
        (length, 0),
        n_elements,
        ancf.Rectangle(0.01, 0.01),
        material,
        velocity=velocity,
    )
    return scene, beam


def law(e):
    """A hardening spring: 2000 N/m at first, 200 times that at an elongation of half a metre."""
    return 2e3 * e + 1.6e6 * e**3


def oscillator(speed, stiffness=law, **options):
    """A bar of 4 kg on a spring of a metre without force in it, thrown along it."""
    scene, beam = carrier(1, 0.5, mass=1.0, stiffness=1e9, velocity=(speed, 0.0))
    scene.add_mass(beam.start, 3.0)
    scene.spring(beam.start, (-1.0, 0.0), stiffness=stiffness, **options)
    return scene, beam


MOVE = ancf.Ramp((0.5, 0.3), 0.4, smooth=True)


def pendulum(
    motion=MOVE, *, youngs_modulus=1e6, damping=0.0, velocity=None, start=(0, 0), **options
):
    """Return a soft pendulum whose support moves, and its rod."""
    material = ancf.Material(youngs_modulus, 4000.0, bending_damping=damping)
    section = ancf.Rectangle(0.01, 0.01)
    end = (start[0] + 2, start[1])
    scene, rod = build_beam("thin", start, end, 6, section, material, velocity=velocity)
    scene.drive(rod.start, motion, **options)
    return scene, rod
