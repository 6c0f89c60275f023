"""Every public function and class with arguments that are valid, to be spoiled one at a time."""

import inspect
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt

import ancfsparse as ancf
from ancfsparse.results.hdf5_reader import load

SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)


@dataclass(frozen=True)
class Call:
    """A callable and what its parameters without defaults are given."""

    name: str
    function: Any
    given: dict[str, Any]

    @cached_property
    def parameters(self):
        """All names that it takes, those with defaults too."""
        return [
            name
            for name, each in inspect.signature(self.function).parameters.items()
            if each.kind not in (each.VAR_POSITIONAL, each.VAR_KEYWORD)
        ]


def scene_of(dim=2):
    pad = (0.0,) * (dim - 2)
    scene = ancf.Scene((0.0, -9.81, *pad))
    rod = scene.add_beam("thin", (0, 0, *pad), (1, 0, *pad), 3, SECTION, MATERIAL)
    return scene, rod


def held_scene():
    scene, rod = scene_of()
    scene.clamp(rod.start)
    return scene, rod


def draw(function, *names):
    """Call a function that draws, and close what it opens."""

    def drawn(**options):
        try:
            return function(**options)
        finally:
            plt.close("all")

    drawn.__signature__ = inspect.signature(function)
    return drawn


def forced(value):
    """Run with a load of which nothing is known."""
    scene, rod = scene_of()
    scene.pin(rod.start)
    scene.point_force(rod.end, value if callable(value) else lambda t: value if t else (0, 0))
    return ancf.simulate(scene, 0.01, 1e-3)


def driven(position):
    """Run with a support of whose motion nothing is known."""
    scene, rod = scene_of()
    function = position if callable(position) else lambda t: position if t else (0, 0)
    scene.drive(rod.start, function)
    return ancf.simulate(scene, 0.01, 1e-3)


def calls():
    """Give all callables, made anew, since some of them change their scene."""
    mpl.use("Agg")
    scene, rod = scene_of()
    space, spatial = scene_of(3)
    other = scene.add_beam("thin", (1, 0), (1, 1), 2, SECTION, MATERIAL)
    stocky = space.add_beam(
        "thick", (0, 3, 0), (1, 3, 0), 2, SECTION, MATERIAL, curvature="section"
    )
    mesh = scene.add_mesh([(5, 0), (6, 0), (6, 1)], [(0, 1), (1, 2)], "thin", SECTION, MATERIAL)
    moving, tip = held_scene()
    moving.save("good.json")
    loaded, _ = held_scene()
    loaded.distributed_force(loaded.beams[0], (0, 1))
    run = ancf.simulate(moving, 0.01, 1e-3)
    ancf.simulate(moving, 0.01, 1e-3, output="good.h5")
    rest = ancf.solve_static(moving)
    beam = {"element": "thin", "start": (0, 2), "end": (1, 2), "n_elements": 3,
            "section": SECTION, "material": MATERIAL}  # fmt: skip
    net = {"nodes": [(7, 0), (8, 0)], "edges": [(0, 1)], "element": "thin",
           "section": SECTION, "material": MATERIAL}  # fmt: skip
    end = {"node": tip.end}
    march = {"scene": moving, "t_end": 0.01, "dt": 1e-3}
    return [
        Call("Scene", ancf.Scene, {}),
        Call("Rectangle", ancf.Rectangle, {"width": 0.01, "height": 0.01}),
        Call("Circle", ancf.Circle, {"diameter": 0.01}),
        Call("Section", ancf.Section, dict.fromkeys(
            ("area", "inertia_y", "inertia_z", "torsion_constant"), 1e-4) | {"inertia_yz": 1e-5}),
        Call("Tube", ancf.Tube, {"diameter": 0.1, "thickness": 0.01}),
        Call("IBeam", ancf.IBeam, {"height": 0.2, "width": 0.1, "web": 0.005, "flange": 0.008}),
        Call("Polygon", ancf.Polygon, {"corners": [(0, 0), (1, 0), (0, 1)]}),
        Call("Taper", ancf.Taper, {"start": SECTION, "end": SECTION}),
        Call("Arc", ancf.Arc, {"centre": (0, 0), "start": (1, 0), "angle": 1.0}),
        Call("Helix", ancf.Helix, {"radius": 1.0, "pitch": 0.1, "turns": 2.0}),
        Call("Material", ancf.Material, {"youngs_modulus": 1e8, "density": 1e3}),
        Call("Newmark", ancf.Newmark, {}),
        Call("HHT", ancf.HHT, {}),
        Call("GeneralizedAlpha", ancf.GeneralizedAlpha, {}),
        Call("RungeKuttaNystrom", ancf.RungeKuttaNystrom, {}),
        Call("Newton", ancf.Newton, {}),
        Call("ModifiedNewton", ancf.ModifiedNewton, {}),
        Call("QuasiNewton", ancf.QuasiNewton, {}),
        Call("add_beam", scene.add_beam, beam),
        Call("add_beam, spatial", space.add_beam,
             beam | {"element": "thick", "start": (0, 2, 0), "end": (1, 2, 0)}),
        Call("add_beam, curved", scene.add_beam,
             {"element": "thin", "curve": ancf.Arc((0, 0), (1, 0), 1.0), "n_elements": 3,
              "section": SECTION, "material": MATERIAL}),
        Call("add_beam, bent and twisted", space.add_beam,
             {"element": "thick", "curve": ancf.Helix(1.0, 0.1, 2.0), "n_elements": 8,
              "section": SECTION, "material": MATERIAL, "rest": "straight", "twist": 1.0}),
        Call("add_beam, slack", scene.add_beam, beam | {"element": "string", "slack": 1e-3}),
        Call("add_beam, eccentric", space.add_beam,
             beam | {"element": "thick", "start": (0, 4, 0), "end": (1, 4, 0),
                     "curvature": "section", "offset": (0.1, 0.2)}),
        Call("add_mesh", scene.add_mesh, net),
        Call("add_mesh, thick", space.add_mesh,
             net | {"nodes": [(7, 2, 0), (8, 2, 0)], "element": "thick"}),
        Call("add_mesh, spatial", space.add_mesh, net | {"nodes": [(7, 0, 0), (8, 0, 0)]}),
        Call("add_frame", space.add_frame,
             {"nodes": [(9, 0, 0), (9, 1, 0), (9, 1, 1)], "edges": [(0, 1), (1, 2)],
              "element": "thick", "n_elements": 2, "section": SECTION, "material": MATERIAL}),
        Call("pin", scene.pin, {"node": rod.start}),
        Call("clamp", scene.clamp, {"node": rod.node(1)}),
        Call("rod", scene.rod, {"node": rod.node(2), "anchor": (0.5, 1)}),
        Call("drive", scene.drive, {"node": rod.node(3), "position": (1, 0)}),
        Call("connect", scene.connect, {"a": rod.end, "b": other.start}),
        Call("point_force", scene.point_force, {"node": rod.end, "value": (1, 0)}),
        Call("point_moment", scene.point_moment, {"node": rod.end, "value": 1.0}),
        Call("point_moment, spatial", space.point_moment,
             {"node": spatial.end, "value": (0, 0, 1)}),
        Call("distributed_force", scene.distributed_force, {"beam": rod, "value": (1, 0)}),
        Call("add_mass", scene.add_mass, {"node": rod.end, "mass": 1.0}),
        Call("add_mass, spatial", space.add_mass, {"node": spatial.end, "mass": 1.0}),
        Call("spring", scene.spring, {"a": rod.end, "b": (3, 0), "stiffness": 1.0}),
        Call("force", scene.force, {"points": [rod.end], "function": lambda q, v, t: 0.0 * q}),
        Call("Scene.refined", moving.refined, {}),
        Call("Scene.replaced", lambda n_elements, material, gravity: moving.replaced(
            tip, n_elements=n_elements, material=material, gravity=gravity),
             {"n_elements": 2, "material": MATERIAL, "gravity": (0, -1)}),
        Call("Scene.replaced, a load", lambda beam, value: loaded.replaced(
            loaded.loads[0], beam=beam, value=value), {"beam": loaded.beams[0], "value": (0, 1)}),
        Call("Scene.counterpart", moving.counterpart, {"handle": tip.end}),
        Call("Scene.save", moving.save, {"path": "good.json"}),
        Call("Scene.load", ancf.Scene.load, {"path": "good.json"}),
        Call("Beam.node", rod.node, {"i": 1}),
        Call("Beam.at", rod.at, {"s": 0.3}),
        Call("Beam.at, beside the axis", stocky.at, {"s": 0.3, "y": 0.01, "z": 0.02}),
        Call("Mesh.node", mesh.node, {"i": 1}),
        Call("Mesh.at", mesh.at, {"edge": 0, "s": 0.3}),
        Call("simulate", ancf.simulate, march),
        Call("simulate to an accuracy", ancf.simulate, march | {"accuracy": 1e-3}),
        Call("simulate explicitly", ancf.simulate,
             march | {"dt": 1e-6, "t_end": 1e-4, "integrator": ancf.RungeKuttaNystrom()}),
        Call("simulate with a load", forced, {"value": (1, 0)}),
        Call("simulate with a drive", driven, {"position": (0, 0)}),
        Call("simulate from a state", ancf.simulate,
             march | {"t_end": 0.02, "start": run.last}),
        Call("solve_static", ancf.solve_static, {"scene": moving}),
        Call("assemble", ancf.assemble, {"scene": moving}),
        Call("load_path", ancf.load_path, {"scene": moving, "points": 4, "branch": 0}),
        Call("quasi_static", ancf.quasi_static, {"scene": moving, "t_end": 0.1, "dt": 0.05}),
        Call("modal_response", ancf.modal_response,
             {"modes": ancf.modes(rest, 2), "t_end": 0.1, "dt": 0.05}),
        Call("buckling", ancf.buckling, {"of": moving}),
        Call("modes", ancf.modes, {"of": rest}),
        Call("complex_modes", ancf.complex_modes, {"of": rest, "n": 3}),
        Call("position", ancf.position, {"point": tip.end}),
        Call("section_force", ancf.section_force, {"point": tip.end}),
        Call("energy", ancf.energy, {}),
        Call("frequency", ancf.frequency, {}),
        Call("plan of an equilibrium", ancf.plan,
             {"scene": moving, "quantity": ancf.static_deflection(tip.end), "error": "5 %"}),
        Call("plan", ancf.plan,
             {"scene": moving, "t_end": 0.02, "quantity": ancf.position(tip.end), "error": "5 %"}),
        Call("simulate for a quantity", ancf.simulate,
             {"scene": moving, "t_end": 0.02, "quantity": ancf.position(tip.end), "error": "5 %"}),
        Call("latin_hypercube", ancf.latin_hypercube, {"n": 3, "length": (1.0, 2.0)}),
        Call("sweep", ancf.sweep,
             {"build": lambda length: moving, "points": [{"length": 1.0}], "t_end": 0.01,
              "quantities": {"end": lambda run: run.t[-1]}, "workers": 1}),
        Call("stable_step", ancf.stable_step,
             {"scene": moving, "integrator": ancf.CentralDifference()}),
        *(Call(f"Trajectory.{name}", getattr(run, name), end) for name in
          ("position", "velocity", "acceleration", "slope", "reaction")),
        *(Call(f"Equilibrium.{name}", getattr(rest, name), end) for name in
          ("position", "displacement", "slope", "reaction")),
        Call("load", load, {"path": "good.h5", "scene": moving}),
        Call("Trajectory.plot", draw(run.plot), {"of": tip, "times": [0.0, 0.01]}),
    ]  # fmt: skip
