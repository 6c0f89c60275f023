"""Calls about what runs, equilibria, modes, plans and scenes give, to be spoiled."""

import inspect

import ancfsparse as ancf
from tests.soak.callables import MATERIAL, SECTION, Call, draw, held_scene
from tests.soak.couplings import Machine


def column():
    """Build an upright beam that a load on its end compresses beyond Euler's load."""
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam("thin", (0, 0), (0, 1), 4, SECTION, MATERIAL)
    scene.clamp(rod.start)
    scene.point_force(rod.end, (0.0, -0.5))
    return scene, rod


def roped():
    """Hang a beam on a rope, in motion and at rest."""
    machine = Machine()
    rope = machine.scene.winch([(0, 3, 0), machine.rod.end])
    scene, rod = held_scene()
    hinge = scene.pin(rod.end, as_constraint=True)
    taut = scene.winch([(2, 3), rod.node(1)])
    return machine.run(), rope, ancf.solve_static(scene), taut, hinge


def recorded(make, names):
    """Make a part of a scene of which nothing is known, and describe, save and load the scene."""

    def made(**given):
        scene, rod = held_scene()
        handle = getattr(scene, make)(**{name: by_name(rod, each) for name, each in given.items()})
        digest, handle = scene.digest(), getattr(handle, "beams", (handle,))[0]
        assert repr(scene.record_of(handle)) in map(repr, scene.records)
        scene.save("recorded.json")
        assert ancf.Scene.load("recorded.json").digest() == digest

    named = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY) for name in names]
    made.__signature__ = inspect.Signature(named)
    return made


def by_name(rod, value):
    """Give a node of a beam by its name; what is no name was spoiled."""
    return getattr(rod, value) if isinstance(value, str) and value in ("start", "end") else value


def records():
    """Give calls whose arguments end in the records of a scene."""
    beam = {"element": "thin", "start": (0, 2), "end": (1, 2), "n_elements": 3,
            "section": SECTION, "material": MATERIAL, "name": "other"}  # fmt: skip
    net = {"nodes": [(7, 0), (8, 0)], "edges": [(0, 1)], "element": "thin",
           "section": SECTION, "material": MATERIAL, "name": "other"}  # fmt: skip
    given = {
        "add_beam": beam,
        "add_mesh": net,
        "add_frame": {**net, "n_elements": 2},
        "add_body": {"mass": 1.0, "position": (5, 5), "inertia": 1.0, "name": "other"},
        "add_mass": {"node": "end", "mass": 1.0},
        "rod": {"node": "end", "anchor": (1, 1)},
        "drive": {"node": "end", "position": ancf.Sine((0.1, 0.1), 1.0)},
        "spring": {"a": "end", "b": (3, 0), "stiffness": 1.0, "length": 1.0, "damping": 0.1},
        "point_force": {"node": "end", "value": ancf.Ramp((1, 0), 0.1)},
        "point_moment": {"node": "end", "value": 1.0},
        "changing_gravity": {"value": ancf.Pulse((1, 0), 0.0, 0.1)},
    }
    return [
        Call(f"{make} and its record", recorded(make, words), words)
        for make, words in given.items()
    ]


def planned(verify, output, save_every, progress, tolerance, solver):
    """Run a plan with options of which nothing is known."""
    scene, rod = held_scene()
    return ancf.plan(scene, 2e-3, ancf.position(rod.end), "5 %").run(
        verify, output=output, save_every=save_every, progress=progress,
        tolerance=tolerance, solver=solver,
    )  # fmt: skip


def asked(kind):
    """Plan for a quantity of which nothing is known."""

    def ask(point, at, error):
        scene, rod = held_scene()
        quantity = kind(by_name(rod, point), at=at)
        return ancf.plan(scene, 2e-3, quantity, error)

    return ask


def output_calls():
    """Give all of them, with scenes of their own."""
    scene, rod = held_scene()
    run = ancf.simulate(scene, 4e-3, 1e-3)
    rest = ancf.solve_static(scene)
    shapes, growing = ancf.modes(rest, 2), ancf.complex_modes(rest, 2)
    pressed, strut = column()
    path = ancf.load_path(pressed, points=4)
    buckled, assembly = ancf.buckling(pressed), ancf.assemble(scene)
    turning, rope, hung, taut, hinge = roped()
    end, over = {"node": rod.end}, {"node": strut.end}
    film = {"path": "run.gif", "seconds": 0.5, "fps": 4, "dpi": 10, "progress": False}
    ask = {"at": "saved", "error": "5 %"}
    sampled = {"build": lambda length: scene, "t_end": 2e-3, "workers": 1,
               "quantities": {"end": lambda run: run.t[-1]}, "dt": 1e-3}  # fmt: skip
    return [
        *records(),
        Call("Scene.record_of", scene.record_of, {"handle": rod}),
        Call("Trajectory.animate", draw(run.animate), film),
        Call("Trajectory.render", run.render, {"path": "run.png", "size": (64, 48)}),
        Call("Trajectory.tension", turning.tension, {"rope": rope}),
        Call("Equilibrium.tension", hung.tension, {"rope": taut}),
        Call("Equilibrium.joint_force", hung.joint_force, {"joint": hinge}),
        *(Call(f"Modes.{name}", getattr(shapes, name), end)
          for name in ("position", "displacement")),
        Call("Modes.state", shapes.state, {"mode": 0, "amplitude": 1e-3}),
        Call("Modes.plot", draw(shapes.plot), {}),
        Call("ComplexModes.moving", growing.moving, {"mode": 0, "amplitude": 1e-3}),
        Call("Buckling.state", buckled.state, {"mode": 0, "amplitude": 1e-3}),
        Call("Buckling.plot", draw(buckled.plot), {}),
        Call("load_path onto a branch", ancf.load_path,
             {"scene": pressed, "points": 4, "branch": 1}),
        *(Call(f"LoadPath.{name}", getattr(path, name), over)
          for name in ("position", "displacement")),
        Call("LoadPath.state", path.state, {"point": 1}),
        Call("LoadPath.plot", draw(path.plot), over),
        *(Call(f"Assembly.{name}", getattr(assembly, name), end)
          for name in ("position", "displacement")),
        Call("Plan.run", planned,
             {"verify": False, "output": None, "save_every": 1, "progress": False,
              "tolerance": "default", "solver": "auto"}),
        *(Call(f"plan for a {kind.__name__}", asked(kind), ask | {"point": point})
          for kind, point in ((ancf.velocity, "end"), (ancf.slope_angle, "end"),
                              (ancf.strain, "end"), (ancf.reaction, "start"))),
        Call("static_deflection", ancf.static_deflection, {"point": rod.end}),
        Call("grid", lambda length, width: ancf.grid(length=length, width=width),
             {"length": (1.0, 2.0), "width": (0.1, 0.2)}),
        Call("sweep with options", lambda points, file, dt, integrator, save_every: ancf.sweep(
            points=points, file=file, integrator=integrator, save_every=save_every,
            **(sampled | {"dt": dt})),
             {"points": [{"length": 1.0}], "file": "sweep.csv", "dt": 1e-3,
              "integrator": ancf.GeneralizedAlpha(), "save_every": 1}),
    ]  # fmt: skip
