"""A scene with beams, bodies and joints, its results, and valid arguments of all callables."""

from functools import cached_property
from unittest.mock import patch

import numpy as np

import ancfsparse as ancf
from ancfsparse.solve.stepping.state_recorder import RunStorage

SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)


class World:
    """Everything that callables are called on and with, made on first use."""

    def __init__(self, dim):
        self.dim = dim
        self.axis = (0.0, 0.0, 1.0) if dim == 3 else None
        self.gravity = self.at(0, -9.81)
        self.scene = scene = ancf.Scene(self.gravity)
        beam = (SECTION, MATERIAL)
        self.rod = scene.add_beam("thin", self.at(0, 0), self.at(1, 0), 3, *beam)
        scene.clamp(self.rod.start)
        self.free = scene.add_beam("thin", self.at(1, 0), self.at(1, 1), 2, *beam)
        self.net = scene.add_mesh([self.at(5, 0), self.at(6, 0)], [(0, 1)], "thin", *beam)
        self.box, self.wheel, self.pinion, self.loose, self.carriage = (
            self.body(x, y) for x, y in ((1, 1), (0, 3), (1, 3), (2, 3), (3, 3))
        )
        self.hinge, self.other = (
            self.turning_on(self.wheel.origin),
            self.turning_on(self.pinion.origin),
        )
        self.axle = self.turning_on(self.carriage.at(self.at(0.2, 0)))  # by multipliers

    def at(self, x, y):
        """Return a point of the plane."""
        return (float(x), float(y), 0.0)[: self.dim]

    def body(self, x, y):
        inertia = 1.0 if self.dim == 2 else (1.0, 1.0, 1.0)
        return self.scene.add_body(mass=1.0, inertia=inertia, position=self.at(x, y))

    def turning_on(self, point):
        """Return a hinge, which is a pin in the plane."""
        if self.dim == 2:
            return self.scene.pin(point)
        return self.scene.revolute(point, axis=self.axis)

    @cached_property
    def held(self):
        """Return a clamped beam with a rope and a hinge, which has an equilibrium."""
        scene = ancf.Scene(self.gravity)
        self.held_rod = scene.add_beam("thin", self.at(0, 0), self.at(1, 0), 3, SECTION, MATERIAL)
        scene.clamp(self.held_rod.start)
        self.rope = scene.winch([self.at(1, 2), self.held_rod.node(2)])
        self.support = scene.pin(self.held_rod.end, as_constraint=True)
        self.floor = scene.contact(self.held_rod, self.half_space, stiffness=1.0, radius=0.01)
        return scene

    @property
    def half_space(self):
        """Return a floor far below."""
        return ancf.HalfSpace(self.at(0, -5), self.at(0, 1))

    @cached_property
    def column(self):
        """Return an upright beam that a load compresses beyond Euler's."""
        scene = ancf.Scene(self.at(0, 0))
        self.strut = scene.add_beam("thin", self.at(0, 0), self.at(0, 1), 4, SECTION, MATERIAL)
        scene.clamp(self.strut.start)
        scene.point_force(self.strut.end, self.at(0, -0.5))
        return scene

    @cached_property
    def turning(self):
        """Return a pinned body that turns."""
        scene = ancf.Scene(self.gravity)
        inertia = 0.1 if self.dim == 2 else (0.1, 0.1, 0.1)
        body = scene.add_body(position=self.at(0, 0), mass=1.0, inertia=inertia)
        scene.pin(body.at(self.at(0.1, 0.2)))
        return scene

    @cached_property
    def saved_scene(self):
        self.held.save("good.json")
        return "good.json"

    @cached_property
    def saved_run(self):
        ancf.simulate(self.held, 4e-3, 1e-3, output="good.h5")
        return "good.h5"

    @property
    def begun_run(self):
        """Return the file of a run that has its last checkpoint; a call resumes it to its end."""
        with patch.object(RunStorage, "remove_checkpoint"):
            ancf.simulate(self.held, 4e-3, 1e-3, output="begun.h5", checkpoint=2)
        return "begun.h5"

    @cached_property
    def motion(self):
        return ancf.simulate(self.scene, 2e-3, 1e-3)

    @cached_property
    def run(self):
        return ancf.simulate(self.held, 4e-3, 1e-3)

    @cached_property
    def rest(self):
        return ancf.solve_static(self.held)

    @cached_property
    def shapes(self):
        return ancf.modes(self.rest, 2)

    @cached_property
    def complex_shapes(self):
        return ancf.complex_modes(self.rest, 2)

    @cached_property
    def path(self):
        return ancf.load_path(self.column, points=4)

    @cached_property
    def buckled(self):
        return ancf.buckling(self.column)

    @cached_property
    def assembly(self):
        return ancf.assemble(self.held)

    @cached_property
    def quantity(self):
        return ancf.position(self.held and self.held_rod.at(0.5))

    @cached_property
    def plan(self):
        return ancf.plan(self.held, 2e-3, self.quantity, "5 %")

    def given(self, name, parameters):
        """Return valid arguments: those that a callable needs, and all that have no default."""
        owner = name.partition(",")[0].rpartition(".")[0]
        found = GIVEN.get(name, lambda world: {})(self)
        for key, each in parameters.items():
            variable = each.kind in (each.VAR_KEYWORD, each.VAR_POSITIONAL)
            if each.default is each.empty and not variable and key not in found:
                found[key] = BY_NAME.get((owner, key), BY_NAME.get(key))(self)
        return found


def beam(world, element="thin", **options):
    """Return the arguments of a beam."""
    shape = {} if "curve" in options else {"start": world.at(0, 2), "end": world.at(1, 2)}
    made = {"n_elements": 3, "section": SECTION, "material": MATERIAL}
    return {"element": element, **shape, **made, **options}


def motion(world, **options):
    return {"scene": world.held, "t_end": 0.01, "dt": 1e-3, **options}


# Valid arguments of parameters without default, by their name, or with that of the owner.
BY_NAME = {
    "scene": lambda w: w.held,
    "node": lambda w: w.held and w.held_rod.end,
    "point": lambda w: w.held and w.held_rod.end,
    "body": lambda w: w.held and w.held_rod,
    "joint": lambda w: w.held and w.support,
    "rope": lambda w: w.held and w.rope,
    "points": lambda w: w.held and [w.held_rod.end],
    "contact": lambda w: w.held and w.floor,
    "base": lambda w: w.at(0, -5),
    "normal": lambda w: w.at(0, 1),
    "path": lambda w: "new.csv",
    "t_end": lambda w: 0.01,
    "modes": lambda w: w.shapes,
    "mode": lambda w: 0,
    "amplitude": lambda w: 1e-3,
    "integrator": lambda w: ancf.CentralDifference(),
    "of": lambda w: w.rest,
    "i": lambda w: 0,
    "s": lambda w: 0.3,
    "edge": lambda w: 0,
    "value": lambda w: w.at(1, 0),
    "start": lambda w: 0.0,
    "end": lambda w: 0.1,
    "times": lambda w: (0.0, 1.0),
    "values": lambda w: [w.at(0, 0), w.at(1, 0)],
    "frequency": lambda w: 2.0,
    **dict.fromkeys(("width", "height", "length", "radius", "diameter"), lambda w: 0.1),
    **dict.fromkeys(("thickness", "web", "flange"), lambda w: 0.01),
    **dict.fromkeys(("area", "inertia_y", "inertia_z", "torsion_constant"), lambda w: 1e-4),
    "youngs_modulus": lambda w: 1e8,
    "density": lambda w: 1e3,
    "corners": lambda w: [(0, 0), (1, 0), (0, 1)],
    "centre": lambda w: w.at(0, 0),
    "angle": lambda w: 1.0,
    "pitch": lambda w: 0.1,
    "turns": lambda w: 2.0,
    "n": lambda w: 3,
    ("Scene", "body"): lambda w: w.rod,
    ("Scene", "obstacle"): lambda w: w.half_space,
    ("Scene", "node"): lambda w: w.free.end,
    ("Scene", "a"): lambda w: w.loose.origin,
    ("Scene", "b"): lambda w: w.rod.end,
    ("Scene", "joint"): lambda w: w.hinge,
    ("Scene", "points"): lambda w: [w.at(1, 3), w.rod.end],
    ("Scene", "handle"): lambda w: w.rod,
    ("Scene", "beam"): lambda w: w.rod,
    ("Scene", "name"): lambda w: w.box.name,
    ("Scene", "path"): lambda w: "new.json",
    ("Scene", "element"): lambda w: "thin",
    ("Scene", "nodes"): lambda w: [w.at(7, 0), w.at(8, 0)],
    ("Scene", "edges"): lambda w: [(0, 1)],
    ("Scene", "section"): lambda w: SECTION,
    ("Scene", "material"): lambda w: MATERIAL,
    ("Scene", "n_elements"): lambda w: 2,
    ("Scene", "stiffness"): lambda w: 1.0,
    ("Scene", "damping"): lambda w: 0.1,
    ("Scene", "ratio"): lambda w: 2.0,
    ("Scene", "one"): lambda w: w.hinge,
    ("Scene", "other"): lambda w: w.other,
    ("Scene", "low"): lambda w: -0.1,
    ("Scene", "high"): lambda w: 0.1,
    ("Scene", "slip"): lambda w: 0.1,
    ("Scene", "anchor"): lambda w: w.at(0.5, 2),
    ("Scene", "position"): lambda w: w.free.end.position,
    ("Scene", "axis"): lambda w: w.at(1, 0),
    ("Scene", "along"): lambda w: w.rod,
    ("Scene", "function"): lambda w: lambda q, v, t: 0.0 * q,
    ("Scene", "angular_velocity"): lambda w: 1.0 if w.dim == 2 else w.axis,
    ("RigidBody", "point"): lambda w: w.at(0.1, 0),
    ("LoadPath", "node"): lambda w: w.column and w.strut.end,
    ("LoadPath", "point"): lambda w: 1,
    ("Buckling", "node"): lambda w: w.column and w.strut.end,
    ("Motion", "body"): lambda w: w.box,
}

TURN = {2: 1.0, 3: (0.0, 0.0, 1.0)}
GIVEN = {
    "Drum": lambda w: {"axis": w.axis} if w.dim == 3 else {},
    "Capsule": lambda w: {"end": w.at(1, -5)},
    "Block": lambda w: {"size": (1.0,) * w.dim},
    "Torus": lambda w: {"ring_radius": 1.0, **({"axis": w.axis} if w.dim == 3 else {})},
    "TriangleMesh": lambda w: {
        "base": (0, 0, -5), "vertices": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
        "triangles": [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], "cell": 0.2,
    },
    "HeightField": lambda w: {"heights": np.zeros((3,) * (w.dim - 1)), "spacing": 1.0},
    "Arc": lambda w: {"start": w.at(1, 0), "axis": w.axis},
    "Taper": lambda w: {"start": SECTION, "end": SECTION},
    "Sine": lambda w: {"amplitude": w.at(1, 0)},
    "SpinUp": lambda w: {"speed": 1.0, "rise": 0.1},
    "Trajectory.history": lambda w: {"what": "velocity"},
    "Trajectory.range": lambda w: {"what": "N", "line": w.held and w.held_rod},
    "Trajectory.report": lambda w: {"path": "new.html"},
    "Trajectory.resample": lambda w: {"times": (0.0, 1e-3)},
    "IBeam": lambda w: {"height": 0.2},
    "Scene.add_beam": beam,
    "Scene.add_beam, curved": lambda w: beam(
        w, curve=ancf.Arc(w.at(0, 0), w.at(1, 0), 1.0, w.axis)
    ),
    "Scene.add_beam, a string": lambda w: beam(w, "string", slack=1e-3),
    "Scene.add_beam, eccentric": lambda w: beam(
        w, "thick", curvature="section", offset=(0.1, 0.2)
    ),
    "Scene.add_beam, bent and twisted": lambda w: beam(
        w, "thick", curve=ancf.Helix(1.0, 0.1, 2.0), n_elements=8, rest="straight", twist=1.0
    ),
    "Scene.add_mesh, thick": lambda w: {"element": "thick"},
    "Scene.add_frame": lambda w: {"element": "thick"},
    "Scene.add_body": lambda w: {
        "mass": 1.0, "position": w.at(5, 5), "inertia": (1, 1, 1) if w.dim == 3 else 1.0
    },
    "Scene.add_body, a shape": lambda w: {
        "shape": ancf.Box(length=1, width=0.2, height=0.5), "mass": 1.0, "position": w.at(5, 5),
        "velocity": w.at(1, 0), "angular_velocity": TURN[w.dim],
    },
    "Scene.add_mass": lambda w: {"mass": 1.0},
    "Scene.clamp": lambda w: {"node": w.free.start},
    "Scene.connect": lambda w: {"a": w.rod.end, "b": w.free.start},
    "Scene.weld": lambda w: {"a": w.box.origin, "b": w.free.end},
    "Scene.revolute": lambda w: {"axis": w.axis} if w.dim == 3 else {},
    "Scene.cylindrical": lambda w: {"axis": w.axis},
    "Scene.universal": lambda w: {"axis_a": (1, 0, 0), "axis_b": w.axis},
    "Scene.spring": lambda w: {"a": w.rod.end, "b": w.at(3, 0), "stiffness": 1.0},
    "Scene.contact": lambda w: {"radius": 0.01},
    "Scene.contact, with a block": lambda w: {
        "obstacle": ancf.Block(w.at(0, -5), (9.0,) * w.dim, 0.1), "radius": 0.01
    },
    "Scene.contact, with ground": lambda w: {
        "obstacle": ancf.HeightField(w.at(-2, -5), np.zeros((3,) * (w.dim - 1)), 2.0),
        "radius": 0.01,
    },
    "Scene.contact, of beams": lambda w: {"obstacle": w.net, "radius": 0.01, "stiffness": 1.0},
    "Scene.contact, that sticks": lambda w: {"radius": 0.01, "friction": 0.1},
    "Scene.contact, that creeps": lambda w: {"radius": 0.01, "friction": 0.1, "slip_speed": 0.01},
    "Scene.contact, that returns": lambda w: {
        "radius": 0.01, "restitution": 0.9, "stiffness": 100.0
    },
    "Scene.contact, with static friction": lambda w: {
        "radius": 0.01, "friction": 0.1, "static_friction": 0.2
    },
    "Scene.contact, of beams that return and stick": lambda w: {
        "obstacle": w.net, "radius": 0.01, "stiffness": 1.0, "restitution": 0.9,
        "friction": 0.1, "static_friction": 0.2,
    },
    "Scene.drive_joint": lambda w: {"value": 0.0},
    "Scene.joint_spring": lambda w: {"stiffness": 1.0},
    "Scene.joint_friction": lambda w: {"size": 0.1},
    "Scene.joint_friction, by a coefficient": lambda w: {
        "joint": w.axle, "coefficient": 0.1, "radius": 0.05
    },
    "Scene.force": lambda w: {"points": [w.rod.end]},
    "Scene.winch, on a drum": lambda w: {"drum": w.hinge, "radius": 0.1},
    "Scene.rope": lambda w: {"stiffness": 100.0, "length": 1.5},
    "Scene.slide": lambda w: {"point": w.body(0.5, 0).origin},
    "Scene.point_moment": lambda w: {"value": TURN[w.dim]},
    "Scene.replaced": lambda w: {"handle": w.rod, "n_elements": 2, "material": MATERIAL},
    "Scene.replaced, a body": lambda w: {"handle": w.box, "mass": 2.0},
    "Scene.load": lambda w: {"path": w.saved_scene},
    "load": lambda w: {"path": w.saved_run, "scene": w.held},
    "resume": lambda w: {"path": w.begun_run, "scene": w.held, "progress": False},
    "Trajectory.animate": lambda w: {
        "path": "run.gif", "seconds": 0.5, "fps": 4, "dpi": 10, "progress": False
    },
    "Trajectory.render": lambda w: {"path": "run.png", "size": (64, 48)},
    "Trajectory.to_gltf": lambda w: {"path": "run.glb"},
    "Trajectory.to_vtk": lambda w: {"path": "run.vtkhdf", "progress": False},
    "Trajectory.joint_force": lambda w: {"frame": "space"},
    "Plan.run": lambda w: {"verify": False, "save_every": 1, "tolerance": "default"},
    "simulate": motion,
    "Simulation": lambda w: {"scene": w.held, "dt": 1e-3},
    "simulate, to an accuracy": lambda w: motion(w, accuracy=1e-3),
    "simulate, from a state": lambda w: motion(w, t_end=0.02, start=w.run.last),
    "simulate, explicitly": lambda w: {
        "scene": w.column, "t_end": 1e-4, "dt": 1e-6, "integrator": ancf.RungeKuttaNystrom()
    },
    "simulate, a body by RATTLE": lambda w: {
        "scene": w.turning, "t_end": 4e-3, "dt": 1e-3, "integrator": ancf.CentralDifference()
    },
    "simulate, for a quantity": lambda w: {
        "scene": w.held, "t_end": 2e-3, "quantity": w.quantity, "error": "5 %"
    },
    "stable_step": lambda w: {"scene": w.column},
    "buckling": lambda w: {"of": w.column},
    "load_path": lambda w: {"scene": w.column, "points": 4},
    "load_path, onto a branch": lambda w: {"scene": w.column, "points": 4, "branch": 1},
    "quasi_static": lambda w: {"t_end": 0.1, "dt": 0.05},
    "modal_response": lambda w: {"t_end": 0.1, "dt": 0.05},
    "plan": lambda w: {"scene": w.held, "t_end": 2e-3, "quantity": w.quantity, "error": "5 %"},
    "plan, of an equilibrium": lambda w: {
        "scene": w.column, "quantity": ancf.static_deflection(w.strut.end), "error": "5 %"
    },
    "grid": lambda w: {"length": (1.0, 2.0), "width": (0.1, 0.2)},
    "latin_hypercube": lambda w: {"n": 3, "length": (1.0, 2.0)},
    "sweep": lambda w: {
        "build": lambda length: w.held, "points": [{"length": 1.0}], "t_end": 2e-3, "workers": 1,
        "quantities": {"end": lambda run: run.t[-1]}, "dt": 1e-3,
    },
}  # fmt: skip
"""Arguments that callables and variants of them need besides, by their names."""
