"""A scene as numbered coordinates, constraints and loads, before any force is assembled."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.scene import Joint, Scene, check_scene
from ancfsparse.scene.bodies.auto_element import check_decided
from ancfsparse.system.coordinates.coordinates import Coordinates
from ancfsparse.system.coordinates.numbering import number_coordinates
from ancfsparse.system.coordinates.state import State, check_state
from ancfsparse.system.loads.applied_loads import collect_loads


class Discretization(Coordinates):
    """The numbered coordinates of a scene with its constraints, prescribed motions and loads.

    The coordinate vector q holds the free coordinates first and the fixed ones after them; within
    each part body by body and node by node.

    Parameters
    ----------
    scene : Scene
        At least one body.
    start : State, optional
        Initial state; by default the reference shape at t = 0 with the initial velocities of the
        bodies.

    Attributes
    ----------
    n_free, n_all, n_multipliers : int
        Numbers of free coordinates, of all coordinates, and of constraint equations.
    q_ref : (n_all,) float
        Stress-free coordinates [m, 1].
    t0 : float
        Initial time [s].
    q0, v0 : (n_all,) float
        Initial coordinates [m, 1] and velocities [m/s, 1/s].
    constraints : Constraints
        The equations with multipliers.
    prescribed : Prescribed
        The motions of the last coordinates and of the last equations over time.
    loads : Loads
        Constant loads and the amplitudes of those that change.
    bodies, joints, attached : tuple
        Those of the scene at construction; the scene may receive more later.
    description : dict of str to str
        Description of the scene at construction, see `Scene.digest`.
    parts : list
        Compiled contributions in the order of assembly, as far as they have been compiled.
    """

    def __init__(self, scene: Scene, start: State | None = None) -> None:
        check_scene(scene)
        if not scene.bodies:
            raise InputError(
                "the scene has no beam: add one with scene.add_beam or scene.add_mesh, or a rigid "
                "body with scene.add_body"
            )
        check_decided(scene.bodies)
        self.scene, self.description = scene, scene.digest()
        self.dim = scene.dim
        self.bodies, self.joints = tuple(scene.bodies), tuple(scene.joints)
        self.attachments = tuple(scene.attachments)
        self.external_loads = tuple(scene.loads)
        self.kinds = [body.kind for body in self.bodies]
        if start is not None:
            check_state(scene, start)
        numbering = number_coordinates(scene, self.kinds, start)
        self.n_free, self.n_all = numbering.n_free, numbering.n_all
        if self.n_free == 0:
            raise InputError("the joints hold every coordinate of the scene: nothing can move")
        self.q_ref, self.places = numbering.q_ref, numbering.places
        self.t0 = 0.0 if start is None else float(start.t)
        self.q0, self.v0 = numbering.q, numbering.v
        self._index = {id(body): k for k, body in enumerate(self.bodies)}
        self.constraints, self.prescribed = numbering.constraints, numbering.prescribed
        self.n_multipliers = len(self.constraints.offset)
        self.loads = collect_loads(scene, self)
        self.parts: list[object] = []

    def rows_of(self, joint: Joint) -> list[int]:
        """Return the numbers of the equations of a joint, in their order."""
        return [k for k, (owner, _) in enumerate(self.constraints.source) if owner == id(joint)]

    def uniform(self, direction: int) -> Vector:
        """Return the translation of all points by 1 along an axis of space, (n_all,)."""
        uniform = np.zeros(self.n_all)
        for places in self.vectors("r"):
            uniform[places[:, direction]] = 1.0
        return uniform
