"""Nodal forces of single elements for many states."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.kernels.layout import pack
from ancfsparse.scene import Beam, ElasticBody
from ancfsparse.system.contributions.bodies.elements import base_parameters, reference_parameters
from ancfsparse.system.coordinates.numbering import reference_coordinates


def element_end_forces(
    body: ElasticBody,
    kind: ElementKind,
    elements: NDArray[np.intp],
    ends: Vector,
    rates: Vector,
    times: Vector,
) -> Vector:
    """Evaluate the generalized nodal forces of elements, including damping.

    Parameters
    ----------
    body : Beam or Mesh
        The body of the elements.
    kind : ElementKind
        Its element type.
    elements : ndarray, shape (p,)
        Numbers of the elements.
    ends, rates : ndarray, shape (k, p, 2 n_c)
        Coordinates and velocities of both nodes of each element in every state.
    times : ndarray, shape (k,)
        Times of the states [s].

    Returns
    -------
    ndarray, shape (k, p, 2 n_c)
        Forces on the ends of each element [N, N m], not summed at nodes.
    """
    q = np.ascontiguousarray(ends).ravel()
    v = np.ascontiguousarray(rates).ravel()
    out = np.zeros_like(q)
    places = np.arange(q.size, dtype=np.int32).reshape(-1, kind.n_coordinates)
    call = compiled_module("kernel_call").call
    kernels = [("force", body.stiffnesses())]
    if body.strains_damped:
        kernels.append(("damping", body.viscosities()))
    for name, common in kernels:
        base = np.tile(base_parameters(body, kind, common)[elements], (len(ends), 1))
        if isinstance(body, Beam) and body.strains_change:
            free = body.free_of_stress_at(reference_coordinates(body)[body.ends], elements, times)
            base[:, reference_parameters(kind)] = free.reshape(len(base), -1)
        layout = pack(kind, places, places, base)
        arrays = layout.gather, layout.scatter, layout.set_of, layout.parameters
        call(kind.kernels[name], *arrays, q, v, out, 1)
    return out.reshape(ends.shape)
