"""Which rigid motions a scene leaves free: what makes a static problem singular."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.scene import Beam, Connect
from ancfsparse.system.system import System


def free_motions(system: System) -> list[str]:
    """Name the rigid motions that no joint prevents, body by body.

    Parameters
    ----------
    system : System
        Looked at in its reference shape.

    Returns
    -------
    list of str
        Empty if the joints hold everything.
    """
    out = []
    held = np.arange(system.n_all) >= system.n_free
    phi_q = system.constraints.jacobian(system.q0)
    for body in _bodies(system):
        motions, names = _rigid_motions(system, body)
        # A turn of a cable about its own axis moves nothing and needs no joint.
        real = np.max(np.abs(motions), axis=0) > 1e-12
        motions = motions[:, real]
        names = [name for name, is_real in zip(names, real, strict=True) if is_real]
        prevented = np.vstack([motions[held], phi_q @ motions])
        _, sizes, directions = np.linalg.svd(prevented)
        rank = int(np.sum(sizes > 1e-9 * max(1.0, float(sizes.max(initial=0.0)))))
        for free in directions[rank:]:
            label = " and ".join(beam.name for beam in body)
            out.append(f"{names[int(np.argmax(np.abs(free)))]} of {label}")
    return out


def _bodies(system: System) -> list[list[Beam]]:
    """Group the beams that are connected."""
    bodies = [[beam] for beam in system.scene.beams]
    for joint in system.scene.joints:
        if isinstance(joint, Connect):
            one = next(b for b in bodies if any(x is joint.a.beam for x in b))
            other = next(b for b in bodies if any(x is joint.b.beam for x in b))
            if one is not other:
                one += other
                bodies.remove(other)
    return bodies


def _rigid_motions(system: System, body: list[Beam]) -> tuple[NDArray[np.float64], list[str]]:
    """Columns: velocity of every coordinate in translations along and turns about the axes."""
    dim = system.dim
    turns = [2] if dim == 2 else [0, 1, 2]
    names = [f"translation along {'xyz'[d]}" for d in range(dim)]
    names += [f"rotation about {'xyz'[d]}" for d in turns]
    motions = np.zeros((system.n_all, len(names)))
    centre = body[0].positions[0]
    for beam in body:
        places = system.places[system.scene.beams.index(beam)]
        for d in range(dim):
            motions[places[:, d], d] = 1.0
        n_vectors = places.shape[1] // dim
        for k in range(n_vectors):
            columns = places[:, dim * k : dim * (k + 1)]
            vectors = np.zeros((len(places), 3))
            vectors[:, :dim] = system.q0[columns] - (centre if k == 0 else 0.0)
            for t, axis in enumerate(turns):
                motions[columns, dim + t] = np.cross(np.eye(3)[axis], vectors)[:, :dim]
    return motions, names
