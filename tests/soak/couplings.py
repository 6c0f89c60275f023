"""Calls about what couples, drives and brakes joints, and about changing gravity, to be spoiled."""

import ancfsparse as ancf
from tests.soak.callables import MATERIAL, SECTION, Call

Z = (0.0, 0.0, 1.0)


class Machine:
    """Two wheels on hinges, a carriage on a slide, a bolt with both, an arm, and a beam."""

    def __init__(self):
        self.scene = scene = ancf.Scene((0.0, -9.81, 0.0))
        self.wheel, self.pinion, self.carriage, self.bolt = (
            scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(x, 0, 0)) for x in range(4)
        )
        self.hinge = scene.revolute(self.wheel.origin, axis=Z)
        self.other = scene.revolute(self.pinion.origin, axis=Z)
        self.slide = scene.prismatic(self.carriage.origin, axis=(1, 0, 0))
        self.screw = scene.cylindrical(self.bolt.origin, axis=Z)
        arm = scene.add_body(
            ancf.Box(length=0.4, width=0.1, height=0.1), mass=1.0, position=(0, -2, 0)
        )
        self.axle = scene.revolute(arm.at((-0.2, 0, 0)), axis=Z)  # by multipliers
        self.rod = scene.add_beam("thin", (0, 2, 0), (1, 2, 0), 2, SECTION, MATERIAL)
        scene.clamp(self.rod.start)

    def __getitem__(self, name):
        """Give a part by its name; what is no name was spoiled."""
        return getattr(self, name) if isinstance(name, str) and hasattr(self, name) else name

    def run(self):
        """Take two steps."""
        return ancf.simulate(self.scene, 2e-3, 1e-3)


def gear(one, other, ratio, of_one, of_other):
    machine = Machine()
    machine.scene.gear(machine[one], machine[other], ratio, of_one=of_one, of_other=of_other)
    return machine.run()


def winch(points, length, rate, second_rate, drum, radius):
    machine = Machine()
    if points is None:
        points = [(0, 3, 0), machine.rod.end]
    rope = machine.scene.winch(
        points, length=length, rate=rate, second_rate=second_rate,
        drum=machine[drum], radius=radius,
    )  # fmt: skip
    return machine.run().tension(rope)


def rope(points, stiffness, damping, length, slack):
    machine = Machine()
    if points is None:
        points = [(0, 3, 0), machine.rod.end]
    made = machine.scene.rope(
        points, stiffness=stiffness, damping=damping, length=length, slack=slack
    )
    return machine.run().tension(made)


def drive_joint(joint, value, rate, second_rate, of, as_constraint=False):
    machine = Machine()
    drive = machine.scene.drive_joint(
        machine[joint],
        value,
        rate=rate,
        second_rate=second_rate,
        of=of,
        as_constraint=as_constraint,
    )
    return machine.run().joint_force(drive)


def joint_spring(joint, stiffness, damping, rest, of):
    machine = Machine()
    machine.scene.joint_spring(
        machine[joint], stiffness=stiffness, damping=damping, rest=rest, of=of
    )
    return machine.run()


def joint_stop(joint, low, high, stiffness, damping, of):
    machine = Machine()
    machine.scene.joint_stop(machine[joint], low, high, stiffness=stiffness, damping=damping, of=of)
    return machine.run()


def joint_friction(joint, size, slip, of, coefficient, radius):
    machine = Machine()
    machine.scene.joint_friction(
        machine[joint], size, slip=slip, of=of, coefficient=coefficient, radius=radius
    )
    return machine.run()


def slide(point, along, lateral):
    machine = Machine()
    if point is None:
        bead = machine.scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(0.5, 2, 0))
        point = bead.origin
    joint = machine.scene.slide(point, machine[along], lateral=lateral)
    return machine.run().joint_force(joint)


def weld(a, b, stretch):
    machine = Machine()
    if a is None:
        plate = machine.scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(1, 2, 0))
        a = plate.origin
    machine.scene.weld(a, machine.rod.end if b is None else b, stretch=stretch)
    return machine.run()


def changing_gravity(value):
    machine = Machine()
    machine.scene.changing_gravity(value)
    return machine.run()


def rotating_frame(angular_velocity, point):
    machine = Machine()
    machine.scene.rotating_frame(angular_velocity, point=point)
    return machine.run()


def joint_force(joint, frame):
    machine = Machine()
    return machine.run().joint_force(machine[joint], frame)


def coupling_calls():
    """Give all of them; each builds a scene of its own."""
    of = {"of": None}
    rates = {"rate": None, "second_rate": None}
    ends = {"low": -0.1, "high": 0.1}
    path = {"points": None, "length": None, **rates, "drum": None, "radius": None}
    rub = {"size": 0.1, "slip": 0.1, "coefficient": None, "radius": None}
    return [
        Call("gear", gear, {"one": "hinge", "other": "other", "ratio": 2.0,
                            "of_one": None, "of_other": None}),
        Call("gear, a screw", gear, {"one": "screw", "other": "screw", "ratio": 2.0,
                                     "of_one": "angle", "of_other": "displacement"}),
        Call("winch", winch, path),
        Call("winch on a drum", winch, path | {"drum": "hinge", "radius": 0.1}),
        Call("winch with a length", winch, path | {"length": lambda t: 2.0**0.5 + t**3}),
        Call("rope", rope, {"points": None, "stiffness": 100.0, "damping": 0.1, "length": 1.5,
                            "slack": 1e-3}),
        Call("drive_joint", drive_joint,
             {"joint": "hinge", "value": 0.0, "as_constraint": False} | rates | of),
        Call("drive_joint, a slide", drive_joint,
             {"joint": "slide", "value": lambda t: t**3} | rates | of),
        Call("joint_spring", joint_spring,
             {"joint": "hinge", "stiffness": 1.0, "damping": 0.1, "rest": 0.0} | of),
        Call("joint_stop", joint_stop,
             {"joint": "hinge", "stiffness": 1.0, "damping": 0.1} | ends | of),
        Call("joint_friction", joint_friction, {"joint": "hinge"} | rub | of),
        Call("joint_friction by a coefficient", joint_friction,
             {"joint": "axle"} | rub | {"size": None, "coefficient": 0.1, "radius": 0.05} | of),
        Call("slide", slide, {"point": None, "along": "rod", "lateral": None}),
        Call("weld to a beam", weld, {"a": None, "b": None, "stretch": "free"}),
        Call("changing_gravity", changing_gravity, {"value": (0, 1, 0)}),
        Call("rotating_frame", rotating_frame,
             {"angular_velocity": (0, 0, 1), "point": None}),
        Call("Trajectory.joint_force", joint_force, {"joint": "hinge", "frame": "space"}),
    ]  # fmt: skip
