"""Points that slide along cables, with reference values of an independent program."""

from __future__ import annotations

from ancfsparse.problems.flexible import add_cable
from ancfsparse.problems.mechanism import GRAVITY, Mechanism
from ancfsparse.scene import Scene


def sliding_bead(n_elements: int = 32) -> Mechanism:
    """Return a bead of 0.1 kg on a cable of 2 m between two pins, free of stress and straight.

    The cable has the section and material of `pendulum`; the bead starts at rest at a quarter of
    its length.

    Quantities: positions of the ``bead`` and of the ``middle`` of the cable [m].
    """
    scene = Scene((0.0, -GRAVITY))
    rope = add_cable(scene, "rope", (0, 0), (2, 0), n_elements)
    scene.pin(rope.start)
    scene.pin(rope.end)
    bead = scene.add_body(mass=0.1, inertia=1e-4, position=(0.5, 0), name="bead")
    scene.slide(bead.origin, rope)
    watched = {
        "bead": lambda run: run.position(bead.origin),
        "middle": lambda run: run.position(rope.at(0.5 * rope.length)),
    }
    return Mechanism(scene, watched)
