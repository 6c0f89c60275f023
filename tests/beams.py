"""Scenes of a single beam."""

import ancfsparse as ancf


def build_beam(
    element, start, end, n_elements, section, material, hold="", hold_end="",
    *, gravity=(0.0, -9.81), **options,
):  # fmt: skip
    """Return a scene with a beam, and the beam, whose ends "pin", "clamp" or nothing holds."""
    scene = ancf.Scene(gravity)
    beam = scene.add_beam(element, start, end, n_elements, section, material, **options)
    for method, node in ((hold, beam.start), (hold_end, beam.end)):
        if method:
            getattr(scene, method)(node)
    return scene, beam
