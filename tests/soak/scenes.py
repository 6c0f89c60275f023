"""Random scenes: one or two straight beams, joints, a load and initial velocities, in any units."""

from dataclasses import dataclass, field

import numpy as np

import ancfsparse as ancf

HOLDS = ("pin", "pin", "clamp", "free", "two pins", "rod", "pin by multipliers", "chain", "rods")
MOTIONS = ("rest", "rest", "spin", "wave", "rough")
LOADS = ("constant", "ramp", "sine", "jump", "pulse")


@dataclass(frozen=True)
class Units:
    """Numbers of a scene for a metre, a kilogram and a second."""

    metre: float = 1.0
    kilogram: float = 1.0
    second: float = 1.0

    @property
    def newton(self):
        return self.kilogram * self.metre / self.second**2


SI = Units()


@dataclass
class Drawn:
    """A scene with its step, in the units it was made in."""

    scene: ancf.Scene
    beams: list
    dt: float
    steps: int
    node: object = None  # where the load acts
    force: object = None  # as a function of time
    words: dict = field(default_factory=dict)
    bodies: list = field(default_factory=list)  # rigid boxes

    @property
    def t_end(self):
        return self.steps * self.dt

    @property
    def cables(self):
        return all(beam.element != "thick" for beam in self.beams)


def draw(rng, units=SI, *, tame=False, held=False):
    """Draw a scene; tame ones move gently, held ones are at rest and have a static shape."""
    m, kg, s = units.metre, units.kilogram, units.second
    element, options = draw_element(rng)
    dim = 2 if element == "l2t2" else int(rng.choice([2, 3]))
    n = int(rng.integers(1, 9 if element == "thick" else 17))
    length = float(10 ** rng.uniform(-0.5, 0.7))
    width = float(length * 10 ** rng.uniform(-2.7, -1))
    modulus = float(10 ** rng.uniform(5, 7.5 if tame else 11.4))
    density = float(10 ** rng.uniform(2.7, 3.95))
    poisson = float(rng.choice([0.0, 0.3, 0.3, 0.45]))
    hold = str(rng.choice(("clamp", "two pins", "rods") if held else HOLDS))
    motion = str(rng.choice(("rest", "spin") if tame else MOTIONS))
    if held or hold in ("rod", "rods"):
        motion = "rest"
    if hold == "two pins" and motion == "spin":
        motion = "wave"
    gravity = np.zeros(dim)
    if motion == "rest" or rng.random() < 0.8:
        gravity[1] = -9.81
    axis, across = directions(rng, dim, straight=hold == "clamp")
    speed = float(10 ** rng.uniform(-0.5, 0.5 if tame else 1.2)) * m / s
    scene = ancf.Scene(gravity * m / s**2)
    material = ancf.Material(
        modulus * kg / m / s**2, density * kg / m**3, poisson, **draw_damping(rng, s)
    )
    section = ancf.Rectangle(width * m, width * m)
    start = np.zeros(dim)
    field = velocities(rng, motion, axis, across, speed, length * m, clamped=hold == "clamp")
    beam = scene.add_beam(
        element, start, start + length * m * axis, n, section, material, velocity=field, **options
    )
    beams = [beam]
    if hold in ("pin", "two pins", "chain", "rod"):
        scene.pin(beam.start)
    if hold == "pin by multipliers":
        scene.pin(beam.start, as_constraint=True)
    if hold == "clamp":
        scene.clamp(beam.start)
    if hold == "two pins":
        scene.pin(beam.end)
    if hold in ("rod", "rods"):
        scene.rod(beam.end, beam.end.position + across * length * m * float(rng.uniform(0.2, 1)))
    if hold == "rods":
        scene.rod(beam.start, beam.start.position + (0.5 * across + 0.3 * axis) * length * m)
    if hold == "chain" and motion == "rest":
        joint = beam.end.position
        other = scene.add_beam(
            element, joint, joint + length * m * across, max(1, n // 2), section, material,
            **options,
        )  # fmt: skip
        scene.connect(beam.end, other.start)
        beams.append(other)
    steps, dt = draw_steps(rng, tame)
    drawn = Drawn(scene, beams, dt * s, steps)
    weight = density * width**2 * length * 9.81
    load = draw_load(rng, drawn, weight * across, units, jumps=not tame)
    drawn.words = {
        "element": element, **options, "dim": dim, "n": n, "length": length, "width": width,
        "modulus": modulus, "density": density, "poisson": poisson, "hold": hold,
        "motion": motion, "gravity": gravity[1], "load": load, "dt": dt, "steps": steps,
    }  # fmt: skip
    return drawn


def draw_element(rng):
    element = str(rng.choice(["thin", "thin", "biot", "l2t2", "thick"]))
    if element == "biot":
        return "thin", {"strain": "biot"}
    if element == "thick":
        return element, {
            "curvature": str(rng.choice(["axis", "section"])),
            "section_strain": str(rng.choice(["consistent", "nodal"])),
        }
    return element, {}


def draw_damping(rng, second):
    damping = {}
    if rng.random() < 0.3:
        damping["axial_damping"] = float(10 ** rng.uniform(-6, -2)) * second
        damping["bending_damping"] = float(10 ** rng.uniform(-6, -2)) * second
    if rng.random() < 0.15:
        alpha, beta = float(rng.uniform(0, 1)), float(10 ** rng.uniform(-6, -3))
        damping["rayleigh"] = (alpha / second, beta * second)
    return damping


def directions(rng, dim, straight):
    """Return the direction of a beam, and one across it."""
    axis = np.zeros(dim)
    angle = 0.0 if straight else rng.uniform(0, 2 * np.pi)
    axis[0], axis[1] = np.cos(angle), np.sin(angle)
    if dim == 2:
        return axis, np.array([-axis[1], axis[0]])
    if not straight:
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
    across = np.cross(axis, rng.normal(size=3))
    return axis, across / np.linalg.norm(across)


def velocities(rng, motion, axis, across, speed, length, clamped):
    """Return initial velocities that satisfy the joints at the start of the beam."""
    if motion == "rest":
        return None
    if clamped:
        return lambda x: np.outer(speed * ((x @ axis) / length) ** 2, across)
    if motion == "spin":
        return lambda x: np.outer((x @ axis) * speed / length, across)
    if motion == "wave":
        waves = int(rng.integers(1, 6))
        return lambda x: np.outer(speed * np.sin(waves * np.pi * (x @ axis) / length), across)
    modes = rng.normal(size=(4, len(axis))) * speed / 2

    def rough(x):
        return sum(
            np.outer(np.sin((k + 1) * np.pi * (x @ axis) / length), mode)
            for k, mode in enumerate(modes)
        )

    return rough


def draw_steps(rng, tame):
    if tame:
        return int(rng.integers(20, 60)), float(10 ** rng.uniform(-3.5, -2.5))
    dt = float(10 ** rng.uniform(-4, -1.5))
    return int(min(400, max(20, 2 / dt))), dt


def draw_load(rng, drawn, weight, units, jumps):
    """Apply a force at the end of the first beam, or none; say which."""
    if rng.random() < 0.5:
        return None
    force = weight * 10 ** rng.uniform(-1, 1.5) * rng.choice([-1, 1]) * units.newton
    period = float(rng.uniform(0.05, 0.5)) * units.second
    kind = str(rng.choice(LOADS if jumps else LOADS[:3]))
    # Jumps and pulses change at no whole step.
    function = {
        "constant": lambda t: force,
        "ramp": lambda t: force * min(1.0, t / period),
        "sine": lambda t: force * np.sin(2 * np.pi * t / period),
        "jump": lambda t: force * (t > 0.37 * period),
        "pulse": lambda t: force * (0.2 * period < t < 0.5 * period),
    }[kind]
    drawn.node, drawn.force = drawn.beams[0].end, function
    drawn.scene.point_force(drawn.node, force if kind == "constant" else function)
    return kind


def draw_integrator(rng):
    return [
        ancf.Newmark(0.0), ancf.Newmark(0.05), ancf.HHT(0.05), ancf.HHT(0.3),
        ancf.GeneralizedAlpha(float(rng.choice([0.0, 0.2, 0.5, 0.8, 0.9, 1.0]))),
        ancf.EnergyMomentum(),
    ][rng.integers(6)]  # fmt: skip


def draw_solver(rng):
    kind, frame = int(rng.integers(9)), str(rng.choice(["auto", "fixed", "rotating"]))
    update = str(rng.choice(["broyden", "davidon", "dfp", "bfgs"]))
    if kind == 0:
        return ancf.Newton()
    if kind == 1:
        return ancf.ModifiedNewton(seed_frame=frame)
    if kind in (2, 3):
        return "auto"
    if kind in (4, 5):
        seed = str(rng.choice(["tangent", "tangent", "finite-difference"]))
        return ancf.QuasiNewton(update, memory="full", seed=seed)
    pairs = int(rng.choice([1, 2, 5, 10, 20]))
    return ancf.QuasiNewton(update, pairs, carry=bool(rng.integers(2)), seed_frame=frame)
