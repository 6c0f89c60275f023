"""The methods of a scene that add loads."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.errors import InputError
from ancfsparse.scene.bodies import ElasticBody, Node
from ancfsparse.scene.joints import check_node, check_point, check_turns
from ancfsparse.scene.loads import (
    DistributedForce,
    DistributedForceSpec,
    PointForce,
    PointForceSpec,
    PointMoment,
    PointMomentSpec,
)
from ancfsparse.scene.records import Records
from ancfsparse.words import shown


class Loads(Records):
    """Loads of a scene."""

    def point_force(
        self, node: Node, value: ArrayLike | Callable[[float], ArrayLike]
    ) -> PointForce:
        """Apply a force at any point of a beam.

        Parameters
        ----------
        node : Node
            Where, for example ``rod.end`` or ``rod.at(0.3)``.
        value : array_like, shape (dim,), or callable
            The force [N], fixed in space, or a function of t [s] that returns it, such as `Ramp`,
            `Sine`, `Pulse` or `Table`.

        Returns
        -------
        PointForce
            The load.
        """
        own = self._mine("a force", check_point("a force", node))
        load = PointForce(own, value)
        return self._load(load, PointForceSpec(own.reference, load.value))

    def point_moment(
        self, node: Node, value: ArrayLike | Callable[[float], ArrayLike]
    ) -> PointMoment:
        """Apply a moment at a node of a beam.

        Parameters
        ----------
        node : Node
            Where, for example ``rod.end``.
        value : float, array_like of shape (3,), or callable
            The moment [N m], fixed in space, or a function of t [s] that returns it: one number
            about +z in a planar scene, three components in a spatial one.  A cable cannot be
            twisted: the part of a moment along its axis does nothing.  A beam with
            ``curvature="section"`` takes a moment on r_y and r_z, all others bend by r_x.

        Returns
        -------
        PointMoment
            The load.
        """
        own = check_turns("a moment", self._mine("a moment", check_node("a moment", node)))
        load = PointMoment(own, value)
        if self.dim == 3 and node.beam.kind.is_cable and not callable(value):
            axis, moment = node.beam.axes_of(node.beam.rows_of(node.index).start)[0], load.at(0.0)
            if moment.any() and np.linalg.norm(np.cross(moment, axis)) <= 1e-9 * np.linalg.norm(
                moment
            ):
                raise InputError(
                    f"the moment on {node!r} is along the axis of a cable, which cannot be "
                    "twisted: take element='thick'"
                )
        return self._load(load, PointMomentSpec(own.reference, load.value))

    def distributed_force(
        self, beam: ElasticBody, value: ArrayLike | Callable[[float], ArrayLike]
    ) -> DistributedForce:
        """Apply a force per reference length along a whole beam or mesh.

        Parameters
        ----------
        beam : Beam or Mesh
            Where.
        value : array_like, shape (dim,), or callable
            The force per length [N/m], fixed in space, or a function of t [s] that returns it,
            such as `Ramp`, `Sine`, `Pulse` or `Table`.

        Returns
        -------
        DistributedForce
            The load.
        """
        if not isinstance(beam, ElasticBody):
            raise InputError(f"a distributed force needs a beam of the scene, got {shown(beam)}")
        load = DistributedForce(self._own("a distributed force", beam), value)
        return self._load(load, DistributedForceSpec(beam.reference, load.value))
