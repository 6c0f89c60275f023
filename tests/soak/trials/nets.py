"""Meshes of random arrays: refused in a sentence, or made of the edges given and able to move."""

import numpy as np
from hypothesis import strategies as st

import ancfsparse as ancf
from tests.soak.report import Report, search

COORDINATES = st.one_of(
    st.integers(-3, 3).map(float),
    st.floats(-10, 10),
    st.floats(allow_nan=True, allow_infinity=True),
)
AT_ONCE = 30  # examples in one trial


@st.composite
def graphs(draw):
    dim = draw(st.sampled_from([2, 3]))
    n, m = draw(st.integers(2, 8)), draw(st.integers(1, 10))
    nodes = draw(st.lists(st.tuples(*[COORDINATES] * dim), min_size=n, max_size=n))
    ends = st.integers(-1, n)
    edges = draw(st.lists(st.tuples(ends, ends), min_size=m, max_size=m))
    return dim, nodes, edges, draw(st.floats(0, 90))


def run(number, index):
    """Search for a mesh that breaks, and reduce it."""
    outcomes = []
    raw = search(number, index, graphs(), lambda *graph: outcomes.append(make(*graph)), AT_ONCE)
    if raw is not None:
        notes = " ".join(getattr(raw, "__notes__", []))
        return Report("broke", [f"{type(raw).__name__}: {raw} {notes}"], "a mesh")
    return Report("searched", [], f"{AT_ONCE} meshes, {outcomes.count('refused')} refused")


def make(dim, nodes, edges, smooth):
    scene = ancf.Scene((0.0, -9.81) + (0.0,) * (dim - 2))
    section, material = ancf.Circle(0.02), ancf.Material(1e7, 1e3)
    try:
        mesh = scene.add_mesh(nodes, edges, "thin", section, material, smooth=smooth)
    except ancf.InputError:
        return "refused"
    given_edges = np.sort(np.asarray(edges), axis=1)
    assert (np.sort(mesh.edges, axis=1) == given_edges).all(), "other edges"
    straight = np.linalg.norm(np.diff(np.asarray(nodes)[given_edges], axis=1)[:, 0], axis=1)
    assert np.allclose(mesh.lengths, straight, rtol=1e-9), "other lengths"
    try:
        run = ancf.simulate(scene, 2e-3, 1e-3)
    except ancf.AncfError:
        return "stopped"
    # Nothing holds it, so that its centre of mass falls freely whatever its parts do.
    assert np.isfinite(run.q).all(), "not finite"
    return "moved"
