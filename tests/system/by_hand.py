"""Scenes of every kind, and their equations put together a second time: element by element, dense.

Only single elements are asked of the package (`tests/kernels` holds those to their energies).
"""

import numpy as np

import ancfsparse as ancf
from ancfsparse.dispatch import compiled_module
from ancfsparse.kernels.catalog import element_kind
from ancfsparse.kernels.layout import pack
from ancfsparse.scene import Clamp, DistributedForce, Pin, PointMoment, RigidRod

SECTION, MATERIAL = ancf.Circle(0.04), ancf.Material(2e7, 1200.0, 0.3)
PLAIN = (MATERIAL,) * 3
DAMPED = (
    ancf.Material(2e7, 1200.0, 0.3, axial_damping=2e-3, bending_damping=0.05),
    ancf.Material(2e7, 1200.0, 0.3, rayleigh=(7.0, 1e-2)),
    ancf.Material(2e7, 1200.0, 0.3, rayleigh=(3.0, 0.0)),
)
"""Materials of the first, second and third beam of a scene."""


def hermite(xi, length):
    """Weights of r0, r0', r1, r1' in r (the cubic with these ends)."""
    return np.array([1 - 3 * xi**2 + 2 * xi**3, length * (xi - 2 * xi**2 + xi**3),
                     3 * xi**2 - 2 * xi**3, length * (xi**3 - xi**2)])  # fmt: skip


def planar_zoo(materials=PLAIN):
    """Two elements in one scene, every joint and every load there is."""
    scene = ancf.Scene((1.0, -9.81))
    one = scene.add_beam("l2t2", (0, 0), (0.6, 0.8), 2, SECTION, materials[0])
    two = scene.add_beam("thin", (0.6, 0.8), (1.8, 0.8), 3, SECTION, materials[1])
    three = scene.add_beam("thin", (0.6, 0.8), (0.6, 1.5), 1, SECTION, materials[2], strain="biot")
    scene.clamp(one.start)
    scene.connect(one.end, two.start)
    scene.connect(two.start, three.start)
    scene.rod(two.end, (2.0, 0.0))
    scene.pin(three.end, as_constraint=True)
    scene.pin(two.node(1))
    scene.point_force(two.at(1.0), (3.0, -4.0))
    scene.point_force(one.node(1), lambda t: (t, 2 * t))
    scene.point_force(three.at(0.2), lambda t: (np.sin(t), 1.0))
    scene.distributed_force(two, (0.5, -0.25))
    scene.distributed_force(one, lambda t: (0.0, 1.0 + t))
    scene.point_moment(one.end, 2.0)
    scene.point_moment(two.start, lambda t: -3.0 * t)
    return scene


def spatial_zoo(moments=True, materials=PLAIN):
    """The same in space, with thick beams."""
    scene = ancf.Scene((0.0, 1.0, -9.81))
    one = scene.add_beam("thin", (0, 0, 0), (0.6, 0.0, 0.8), 2, SECTION, materials[0])
    two = scene.add_beam("thick", (0.6, 0, 0.8), (0.6, 1.2, 0.8), 2, SECTION, materials[1])
    three = scene.add_beam(
        "thin", (0.6, 0, 0.8), (1.3, 0.1, 0.8), 1, SECTION, materials[2], strain="biot"
    )
    scene.clamp(one.start)
    scene.connect(one.end, two.start)
    scene.connect(one.end, three.start)
    scene.rod(two.end, (2.0, 0.0, 0.3))
    scene.rod(two.end, (0.0, 2.0, 0.3))
    scene.pin(three.end, as_constraint=True)
    scene.point_force(two.at(0.3), (3.0, -4.0, 1.0))
    scene.point_force(one.node(1), lambda t: (t, 2 * t, -t))
    scene.distributed_force(two, lambda t: (0.5, -0.25, t))
    scene.distributed_force(three, (0.1, 0.2, 0.3))
    if moments:
        scene.point_moment(three.start, (2.0, -1.0, 0.5))
        scene.point_moment(two.node(1), lambda t: (t, 1.0, -2.0))
    return scene


def planar_thick_zoo(materials=PLAIN):
    scene = ancf.Scene((0.0, -9.81))
    one = scene.add_beam("thick", (0, 0), (1, 0), 2, SECTION, materials[0])
    nodal = {"curvature": "section", "section_strain": "nodal"}
    two = scene.add_beam("thick", (1, 0), (1.5, 0.5), 2, SECTION, materials[1], **nodal)
    scene.clamp(one.start)
    scene.connect(one.end, two.start)
    scene.rod(two.end, (1.5, 2.0))
    scene.distributed_force(one, (1.0, 2.0))
    scene.point_moment(one.node(1), 3.0)
    scene.point_moment(two.node(1), -2.0)
    return scene


def spatial_section_zoo(materials=PLAIN):
    """Beams that shear, with a clamp and moments on their sections."""
    scene = ancf.Scene((0.0, 1.0, -9.81))
    one = scene.add_beam(
        "thick", (0, 0, 0), (0.6, 0.3, 0.8), 2, SECTION, materials[0], curvature="section"
    )
    nodal = {"curvature": "section", "section_strain": "nodal"}
    end = (0.6, 1.2, 0.8)
    two = scene.add_beam("thick", one.end.position, end, 2, SECTION, materials[1], **nodal)
    scene.clamp(one.start)
    scene.connect(one.end, two.start)
    scene.rod(two.end, (2.0, 0.0, 0.3))
    scene.point_moment(one.end, (2.0, -1.0, 0.5))
    scene.point_moment(two.node(1), lambda t: (t, 1.0, -2.0))
    return scene


ZOO = {
    "planar": planar_zoo,
    "spatial": spatial_zoo,
    "spatial, no moments": lambda: spatial_zoo(moments=False),
    "planar thick": planar_thick_zoo,
    "spatial section": spatial_section_zoo,
    "planar, damped": lambda: planar_zoo(DAMPED),
    "spatial, damped": lambda: spatial_zoo(materials=DAMPED),
    "planar thick, damped": lambda: planar_thick_zoo(DAMPED),
    "spatial section, damped": lambda: spatial_section_zoo(DAMPED),
}


class ByHand:
    """r = M a + C v + Q - f + phi_q^T lam, with dense matrices over all coordinates."""

    def __init__(self, system):
        self.system, self.scene, self.n = system, system.scene, system.n_all
        self.call = compiled_module("kernel_call").call
        self.mass = self._matrix("mass", np.zeros(self.n))

    def _run(self, beam, places, kernel, q, damping=False):
        """What a kernel gives for each element of a beam, elements apart."""
        kind = element_kind(beam.element, self.scene.dim, **beam.options)
        n_e, n = places.shape
        n_out = kind.n_out(kernel)
        values = beam.parameters()
        if damping:
            values |= beam.viscosities()
        base = [[values[name] for name in kind.parameters]] * n_e
        own = np.arange(n_e * n).reshape(n_e, n)
        layout = pack(kind, own, np.arange(n_e * n_out).reshape(n_e, n_out), base)
        out, q_e = np.zeros((n_e, n_out)), np.ascontiguousarray(q[places]).ravel()
        self.call(
            kind.kernels[kernel], layout.gather, layout.scatter, layout.set_of,
            layout.parameters, q_e, q_e, out.ravel(),
        )  # fmt: skip
        return out

    def _elements(self):
        for beam, nodes in zip(self.scene.beams, self.system.places, strict=True):
            yield beam, np.hstack([nodes[:-1], nodes[1:]])

    def _matrix(self, kernel, q, damping=False):
        out = np.zeros((self.n, self.n))
        for beam, places in self._elements():
            n = places.shape[1]
            i, j = np.tril_indices(n)
            rows = self._run(beam, places, kernel, q, damping)
            for where, numbers in zip(places, rows, strict=True):
                block = np.zeros((n, n))
                block[i, j] = block[j, i] = numbers
                np.add.at(out, (where[:, None], where[None, :]), block)
        return out

    def tangent(self, q):
        return self._matrix("tangent", q)

    def damping(self, q):
        """Derivative of the force by the velocities."""
        return self._matrix("material", q, damping=True) + self._matrix("mass", q, damping=True)

    def force(self, q):
        out = np.zeros(self.n)
        for beam, places in self._elements():
            np.add.at(out, places, self._run(beam, places, "force", q))
        return out

    def _vector(self, node, q, k):
        """Nodal vector number k of a node: 0 is r, 1 is r_x; and its places."""
        dim = self.scene.dim
        nodes = self.system.places[self.scene.beams.index(node.beam)]
        where = nodes[node.index, dim * k : dim * (k + 1)]
        return q[where], where

    def applied(self, q, t):
        """Applied forces, gravity included, by integrals of the shape functions."""
        dim = self.scene.dim
        field = np.zeros(self.n)
        for places in self.system.places:
            field[places[:, :dim]] = self.scene.gravity
        f = self.mass @ field
        for load in self.scene.loads:
            value = load.at(t)
            if isinstance(load, PointMoment):
                m = np.zeros(3)
                m[3 - len(value) :] = value
                if load.node.beam.options.get("curvature") == "section":
                    self._add_on_section(f, q, load.node, m)
                    continue
                slope, where = self._vector(load.node, q, 1)
                x = np.zeros(3)
                x[:dim] = slope
                f[where] += (np.cross(m, x) / (x @ x))[:dim]
                if load.node.beam.element == "thick" and dim == 3:
                    # What the slope cannot take, the part along the axis, goes to r_y and r_z.
                    along = x * (m @ x) / (x @ x)
                    for k in (2, 3):
                        y, where = self._vector(load.node, q, k)
                        f[where] += 0.5 * np.cross(along, y) / (y @ y)
                continue
            beam = load.beam if isinstance(load, DistributedForce) else load.node.beam
            nodes = self.system.places[self.scene.beams.index(beam)]
            length = beam.length / beam.n_elements
            if isinstance(load, DistributedForce):
                xi, w = np.polynomial.legendre.leggauss(4)
                points = [(e, (x + 1) / 2, length * v / 2) for e in range(beam.n_elements)
                          for x, v in zip(xi, w, strict=True)]  # fmt: skip
            elif load.node.index == beam.n_elements:
                points = [(beam.n_elements - 1, 1.0, 1.0)]
            else:
                points = [(load.node.index, load.node.xi, 1.0)]
            for e, x, weight in points:
                shape = hermite(x, length) * weight
                for d in range(dim):
                    where = [nodes[e, d], nodes[e, dim + d], nodes[e + 1, d], nodes[e + 1, dim + d]]
                    f[where] += shape * value[d]
        return f

    def _add_on_section(self, f, q, node, m):
        """Add the smallest forces on r_y, and in space r_z, that have the moment m."""
        dim = self.scene.dim
        found = [self._vector(node, q, k) for k in ((2, 3) if dim == 3 else (2,))]
        arms = []
        for vector, _ in found:
            arm = np.zeros(3)
            arm[:dim] = vector
            arms += [np.cross(arm, e) for e in np.eye(3)[:dim]]
        turns = slice(None) if dim == 3 else slice(2, 3)
        forces = np.linalg.lstsq(np.array(arms).T[turns], m[turns])[0]
        f[np.concatenate([where for _, where in found])] += forces

    def phi(self, q):
        """Constraints in the order of the joints."""
        out = []
        for joint in self.scene.joints:
            if isinstance(joint, Pin) and joint.as_constraint:
                out += list(self._vector(joint.node, q, 0)[0] - joint.node.position)
            elif isinstance(joint, RigidRod):
                gap = self._vector(joint.node, q, 0)[0] - joint.anchor
                out.append((gap @ gap - joint.length**2) / (2 * joint.length))
            elif isinstance(joint, Clamp) and joint.node.beam.element != "thick":
                axes = joint.node.beam.axes
                oblique = np.sum(np.abs(axes[0]) > 1e-12) > 1
                if oblique and joint.stretch == "free":
                    slope = self._vector(joint.node, q, 1)[0]
                    length = np.mean(joint.node.beam.lengths)
                    out += [length * each @ slope for each in axes[1:]]
        return np.array(out)

    def phi_q(self, q, step=1e-6):
        """Exact for quadratic equations but for rounding."""
        columns = []
        for e in np.eye(self.n):
            columns.append((self.phi(q + step * e) - self.phi(q - step * e)) / (2 * step))
        return np.array(columns).T.reshape(-1, self.n)

    def residual(self, q, a, lam, t):
        return self.mass @ a + self.force(q) - self.applied(q, t) + self.phi_q(q).T @ lam


def state(system, rng, size=0.05):
    """Somewhere near the reference shape, moving."""
    q = system.q0 + size * rng.uniform(-1, 1, system.n_all)
    q[system.n_free :] = system.q0[system.n_free :]
    return q, 10 * rng.normal(size=system.n_all), 50 * rng.normal(size=system.n_multipliers)
