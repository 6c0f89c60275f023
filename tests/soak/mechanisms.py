"""Calls about rigid bodies, their joints, functions of time, modes and outputs, to be spoiled."""

import numpy as np

import ancfsparse as ancf
from tests.soak.callables import MATERIAL, SECTION, Call, draw

Z = (0.0, 0.0, 1.0)


def hung(dim=3):
    """Hang a body on the end of a cable, which begins at a clamp."""
    pad = (0.0,) * (dim - 2)
    scene = ancf.Scene((0.0, -9.81, *pad))
    rod = scene.add_beam("thin", (0, 0, *pad), (1, 0, *pad), 2, SECTION, MATERIAL)
    scene.clamp(rod.start)
    box = scene.add_body(
        ancf.Box(length=0.4, width=0.1, height=0.2), mass=0.2, position=(1.2, 0, *pad)
    )
    scene.connect(rod.end, box.at((-0.2, 0, *pad)))
    return scene, rod, box


def joined(name):
    """Give a function that makes a joint between new bodies, so that none is redundant."""

    def make(a, b, **options):
        scene, _, box = hung()
        other = scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(1.2, 0, 0))
        places = {"a": box.origin, "b": other.origin}
        a, b = (places.get(each, each) if isinstance(each, str) else each for each in (a, b))
        getattr(scene, name)(a, b, **options)
        return ancf.simulate(scene, 2e-3, 1e-3)

    return make


def revolute(a, b, axis):
    return joined("revolute")(a, b, axis=axis)


def universal(a, b, axis_a, axis_b):
    return joined("universal")(a, b, axis_a=axis_a, axis_b=axis_b)


def cylindrical(a, b, axis):
    return joined("cylindrical")(a, b, axis=axis)


def prismatic(a, b, axis):
    return joined("prismatic")(a, b, axis=axis)


def weld(a, b):
    return joined("weld")(a, b)


def distance(a, b):
    scene, _, box = hung()
    other = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(1.5, 1, 0))
    places = {"a": box.origin, "b": other.end}
    a, b = (places.get(each, each) if isinstance(each, str) else each for each in (a, b))
    scene.distance(a, b)
    return ancf.simulate(scene, 2e-3, 1e-3)


def moved(shape, position, mass, inertia, orientation, velocity, angular_velocity):
    """Run a free body of which nothing is known."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    body = scene.add_body(
        shape, position=position, mass=mass, inertia=inertia, orientation=orientation,
        velocity=velocity, angular_velocity=angular_velocity,
    )  # fmt: skip
    return ancf.simulate(scene, 2e-3, 1e-3).body(body).rotation


def rubbed(size, coefficient, radius, slip, of):
    """Run a wheel whose axle rubs."""
    scene = ancf.Scene((0.0, -9.81))
    wheel = scene.add_body(mass=2.0, inertia=0.02, position=(0, 0), angular_velocity=3.0)
    pin = scene.pin(wheel.origin, as_constraint=True)
    scene.joint_friction(pin, size, slip=slip, of=of, coefficient=coefficient, radius=radius)
    return ancf.simulate(scene, 2e-3, 1e-3)


def turned(angular_velocity, inertia, t_end, dt, integrator):
    """Run a body by an explicit integrator."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    body = scene.add_body(
        position=(0, 0, 0), mass=1.0, inertia=inertia, angular_velocity=angular_velocity
    )
    scene.pin(body.at((0.1, 0.2, 0.3)))
    return ancf.simulate(scene, t_end, dt, integrator=integrator)


def signalled(signal, **given):
    """Run with a function of time of which nothing is known."""
    scene, rod, _ = hung(2)
    scene.point_force(rod.end, signal(**given))
    return ancf.simulate(scene, 2e-3, 1e-3)


def ramp(value, end, start, smooth):
    return signalled(ancf.Ramp, value=value, end=end, start=start, smooth=smooth)


def sine(amplitude, frequency, phase):
    return signalled(ancf.Sine, amplitude=amplitude, frequency=frequency, phase=phase)


def pulse(value, start, end, rise):
    return signalled(ancf.Pulse, value=value, start=start, end=end, rise=rise)


def table(times, values, outside):
    return signalled(ancf.Table, times=times, values=values, outside=outside)


def mechanism_calls():
    """Give all of them, with scenes of their own."""
    scene, rod, box = hung()
    flat, _, _ = hung(2)
    run = ancf.simulate(scene, 4e-3, 1e-3)
    held = ancf.Scene((0.0, -9.81))
    beam = held.add_beam("thin", (0, 0), (1, 0), 3, SECTION, MATERIAL)
    held.clamp(beam.start)
    rest = ancf.solve_static(held)
    pair = {"a": "a", "b": "b"}
    body = {"position": (5, 5, 5), "mass": 1.0}
    free = {"shape": ancf.Box(length=1, width=0.2, height=0.5), "position": (0, 0, 0),
            "mass": 1.0, "inertia": None,
            "orientation": None, "velocity": (1, 0, 0), "angular_velocity": (1, 2, 3)}  # fmt: skip
    along = {"body": rod}
    return [
        Call("Box", ancf.Box, {"length": 1.0, "height": 0.5, "width": 0.2}),
        Call("Cylinder", ancf.Cylinder, {"radius": 0.1, "length": 1.0}),
        Call("Sphere", ancf.Sphere, {"radius": 0.1}),
        Call("Rod", ancf.Rod, {"length": 1.0}),
        Call("add_body", scene.add_body, body | {"inertia": (1, 1, 1)}),
        Call("add_body, a shape", scene.add_body, body | {"shape": ancf.Sphere(0.1)}),
        Call("add_body, planar", flat.add_body, {"position": (5, 5), "mass": 1.0, "inertia": 1.0}),
        Call("add_body and a run", moved, free),
        Call("RigidBody.at", box.at, {"point": (0.1, 0, 0)}),
        Call("joint_friction", rubbed, {"size": None, "coefficient": 0.2, "radius": 0.01,
                                        "slip": 1e-3, "of": None}),
        Call("simulate, a body by RATTLE", turned, {
            "angular_velocity": (1, 2, 3), "inertia": (0.1, 0.1, 0.1), "dt": 1e-3, "t_end": 4e-3,
            "integrator": ancf.CentralDifference()}),
        Call("simulate, a body by DormandPrince", turned, {
            "angular_velocity": (1, 2, 3), "inertia": (0.1, 0.1, 0.1), "dt": 1e-2, "t_end": 4e-2,
            "integrator": ancf.DormandPrince()}),
        Call("revolute", revolute, pair | {"axis": Z}),
        Call("universal", universal, pair | {"axis_a": Z, "axis_b": (1, 0, 0)}),
        Call("cylindrical", cylindrical, pair | {"axis": Z}),
        Call("prismatic", prismatic, pair | {"axis": Z}),
        Call("weld", weld, pair),
        Call("distance", distance, pair),
        Call("Ramp", ramp, {"value": (1, 0), "end": 0.1, "start": 0.0, "smooth": False}),
        Call("Sine", sine, {"amplitude": (1, 0), "frequency": 2.0, "phase": 0.0}),
        Call("Pulse", pulse, {"value": (1, 0), "start": 0.0, "end": 0.1, "rise": 0.0}),
        Call("Table", table,
             {"times": (0.0, 1.0), "values": [(0, 0), (1, 0)], "outside": "error"}),
        Call("modes", ancf.modes, {"of": held}),
        Call("modes about an equilibrium", ancf.modes, {"of": rest, "n": 2}),
        Call("complex_modes", ancf.complex_modes, {"of": held, "n": 2}),
        Call("Trajectory.body", run.body, {"body": box}),
        *(Call(f"Trajectory.{name}", getattr(run, name), along)
          for name in ("strain", "curvature", "section_force")),
        *(Call(f"Equilibrium.{name}", getattr(rest, name), {"body": beam})
          for name in ("strain", "curvature", "section_force")),
        Call("Trajectory.plot", draw(run.plot), {}),
        Call("Equilibrium.plot", draw(rest.plot), {}),
        Call("Trajectory.to_csv", run.to_csv, {"path": "run.csv", "points": [rod.end]}),
        Call("Trajectory.to_vtk", run.to_vtk, {"path": "run.vtkhdf", "progress": False}),
        Call("Scene.counterpart, a body", scene.counterpart, {"handle": box}),
        Call("Scene.replaced, a body", lambda mass, position: scene.replaced(
            box, mass=mass, position=position), {"mass": 2.0, "position": np.array([1.2, 0, 0])}),
    ]  # fmt: skip
