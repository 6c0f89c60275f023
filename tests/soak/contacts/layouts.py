"""Layouts of scenes with contacts: each adds its parts to a draft and returns the time of a run."""

import math

import numpy as np

import ancfsparse as ancf
from tests.grids import grid
from tests.soak.contacts.draft import GRAVITY, REST, SINKING

SAG = 0.02  # of arcs around drums, over the radius of the cable
QUARTER = 0.5 * math.pi  # of a drum, the longest element that a contact admits [rad]


def fall(draft):
    """Let a cable or a beam fall on a floor, a ball or a drum."""
    rng, length = draft.rng, draft.length
    kind = str(rng.choice(["half-space", "ball", "drum"]))
    if kind == "half-space":
        size, n = 0.0, int(rng.integers(2, 13))
        obstacle = ancf.HalfSpace(draft.at(0.3 * length, 0), draft.along(0, 2.0))
    else:
        size = float(length * 10 ** rng.uniform(-1, 0.3))
        n = count(draft, length, size)
        slant = float(rng.uniform(-0.5, 0.5))
        obstacle = drum(draft, size, slant) if kind == "drum" else ancf.Ball(draft.at(0, 0), size)
    tilt = float(rng.uniform(-0.4, 0.4)) * int(rng.integers(2))
    start, end = place_above(draft, obstacle, tilt, float(rng.uniform(-0.3, 0.3)) * length)
    sliding = float(rng.uniform(-1, 1)) * draft.speed
    velocity = draft.along(sliding, -draft.speed) if draft.speed else None
    beam = draft.line(start, end, n, velocity=velocity)
    is_pinned = draft.speed == 0.0 and bool(rng.random() < 0.5)
    if is_pinned:
        draft.scene.pin(beam.start)
    draft.words |= {"pinned": is_pinned, "n": n, "tilt": tilt}
    draft.touch(beam, obstacle)
    return draft.draw_duration(5 if is_pinned else 3)


def place_above(draft, obstacle, tilt, offset):
    """Return the ends of a line whose lowest way down to an obstacle is the gap."""
    half = 0.5 * draft.length * np.array([math.cos(tilt), math.sin(tilt)])
    shares = np.linspace(-1.0, 1.0, 41)
    line = draft.at(offset, 0) + np.outer(shares, draft.along(*half))
    low, high = 0.0, obstacle.radius + draft.length
    for _ in range(50):
        middle = 0.5 * (low + high)
        distances = obstacle.distances(line + draft.along(0, middle))
        low, high = (low, middle) if distances.min() > draft.radius else (middle, high)
    lift = draft.along(0, high + draft.gap)
    return line[0] + lift, line[-1] + lift


def count(draft, length, size):
    """Return a number of elements of which each covers less than a quarter of a round obstacle."""
    least = max(2, math.ceil(1.1 * length / (QUARTER * size)))
    return int(draft.rng.integers(least, least + 8))


def drum(draft, size, slant=0.0):
    """Return a drum that stands still or turns, with its axis across."""
    spin = 0.0
    if draft.rng.random() < 0.5:
        spin = float(draft.rng.uniform(-1, 1)) * math.sqrt(GRAVITY * draft.length) / size
    axis = draft.along(math.sin(slant), 0, math.cos(slant)) if draft.dim == 3 else None
    return ancf.Drum(draft.at(0, 0), size, axis=axis, angular_velocity=spin)


def hang(draft):
    """Hang a cable over a drum, so that its ends fall."""
    rng, length = draft.rng, draft.length
    size = float(length * rng.uniform(0.08, 0.3))
    draft.gap *= 0.1
    offset, height = float(rng.uniform(-0.2, 0.2)) * length, size + draft.radius + draft.gap
    n = count(draft, length, size)
    beam = draft.line(
        draft.at(offset - 0.5 * length, height), draft.at(offset + 0.5 * length, height), n
    )
    draft.touch(beam, drum(draft, size), tension=0.5 * draft.weight * length)
    draft.words |= {"n": n, "offset": offset}
    return math.sqrt(length / GRAVITY) * float(rng.uniform(0.5, 2))


def arc(draft, size, angle):
    """Add a cable around a drum, from its left side over its top; return it and its ends' ways."""
    reach = size + draft.radius
    start = draft.at(-reach, 0)
    axis = draft.along(0, 0, 1) if draft.dim == 3 else None
    is_bent = draft.element == "l2t2" or (draft.dim == 3 and draft.element == "thin")
    rest = "straight" if is_bent or draft.rng.random() < 0.3 else "curved"
    draft.curvature = 1.0 / reach if rest == "straight" else 0.0
    # An arc of cubics of the angle a cuts into the drum by size a^4 / 384.
    finest = (384 * SAG * draft.radius / size) ** 0.25
    least = max(math.ceil(1.1 * angle / QUARTER), math.ceil(0.5 * angle / finest))
    n = int(draft.rng.integers(2 * least, 8 * least))
    beam = draft.keep(
        draft.scene.add_beam(
            draft.element, curve=ancf.Arc(draft.at(0, 0), start, -angle, axis),
            n_elements=n, section=draft.section, material=draft.material, rest=rest,
            **draft.options,
        )
    )  # fmt: skip
    draft.words |= {"n": n, "angle": angle, "rest": rest}
    leaving = draft.along(math.sin(angle), math.cos(angle))
    return beam, draft.along(0, -1), leaving


def draw_force(draft, angle, size):
    """Return a force of a wrapped cable that stretches it by at most a hundredth [N]."""
    weight = draft.weight * angle * size
    most = 0.01 * draft.modulus * draft.section.area
    return min(weight * float(10 ** draft.rng.uniform(-0.3, 1.5)), most)


def wrap(draft):
    """Wrap a cable around a drum, held at one end and pulled at the other, or at both."""
    rng = draft.rng
    angle, size = float(rng.uniform(1, 5)), float(draft.length * rng.uniform(0.2, 0.4))
    draft.gap = 0.0
    beam, back, forth = arc(draft, size, angle)
    force = draw_force(draft, angle, size)
    duration = math.sqrt(size / GRAVITY) * float(rng.uniform(0.5, 2))
    ramp = 0.3 * duration
    draft.pull(beam.end, force * forth, ramp)
    is_pinned = bool(rng.random() < 0.6)
    if is_pinned:
        draft.scene.pin(beam.start)
    else:
        other = force * float(rng.uniform(0.5, 2))
        draft.pull(beam.start, other * back, ramp)
    draft.touch(beam, drum(draft, size), tension=2 * force)
    draft.words |= {"force": force, "pinned": is_pinned}
    return duration


def pulley(draft):
    """Wrap a cable around a pulley, and pull both ends."""
    rng = draft.rng
    angle, size = float(rng.uniform(1, 3.5)), float(draft.length * rng.uniform(0.2, 0.4))
    draft.gap = 0.0
    beam, back, forth = arc(draft, size, angle)
    mass = draft.density * draft.section.area * angle * size * float(10 ** rng.uniform(-1, 1))
    wheel = draft.scene.add_body(mass=mass, inertia=0.5 * mass * size**2, position=draft.at(0, 0))
    draft.scene.pin(wheel.origin)
    draft.bodies.append(wheel)
    force = draw_force(draft, angle, size)
    duration = math.sqrt(size / GRAVITY) * float(rng.uniform(0.3, 1))
    for end, way, share in ((beam.start, back, 1.0), (beam.end, forth, float(rng.uniform(0.7, 1)))):
        draft.pull(end, share * force * way, 0.3 * duration)
    draft.touch(beam, ancf.Drum(draft.at(0, 0), size), tension=2 * force, on=wheel)
    draft.words |= {"force": force, "mass": mass}
    return duration


def throw(draft):
    """Throw a rigid ball on a cable that hangs between two pins, or is free."""
    rng, length = draft.rng, draft.length
    size = float(length * rng.uniform(0.1, 0.4))
    height = size + draft.radius + draft.gap
    n = count(draft, length, size)
    beam = draft.line(draft.at(-0.5 * length, 0), draft.at(0.5 * length, 0), n)
    if rng.random() < 0.6:
        draft.scene.pin(beam.start)
        draft.scene.pin(beam.end)
    else:  # both fall freely, so only the speed brings them together
        draft.speed = draft.speed or math.sqrt(GRAVITY * length)
        draft.closing = 0.0
    mass = draft.density * draft.section.area * length * float(10 ** rng.uniform(-1, 0.5))
    spin = float(rng.uniform(-1, 1)) * draft.speed / size
    inertia = 0.4 * mass * size**2
    centre = draft.at(float(rng.uniform(-0.3, 0.3)) * length, height)
    ball = draft.scene.add_body(
        mass=mass, inertia=inertia if draft.dim == 2 else (inertia,) * 3, position=centre,
        velocity=draft.along(0.3 * draft.speed, -draft.speed),
        angular_velocity=spin if draft.dim == 2 else spin * rng.normal(size=3),
    )  # fmt: skip
    draft.bodies.append(ball)
    draft.touch(beam, ancf.Ball(centre, size), on=ball)
    draft.words |= {"n": n, "mass": mass}
    return draft.draw_duration(4)


def ropes(draft):
    """Let a rope fall across another one, which hangs between two pins or is free."""
    rng, length = draft.rng, draft.length
    n, height = int(rng.integers(4, 10)), 2 * draft.radius + draft.gap
    lower = draft.line(draft.at(-0.5 * length, 0), draft.at(0.5 * length, 0), n)
    if rng.random() < 0.7:
        draft.scene.pin(lower.start)
        draft.scene.pin(lower.end)
    else:
        draft.speed = draft.speed or math.sqrt(GRAVITY * length)
        draft.closing = 0.0
    angle, offset = float(rng.uniform(0.1, QUARTER)), float(rng.uniform(-0.2, 0.2)) * length
    half = 0.5 * length * np.array([math.cos(angle), math.sin(angle)])
    velocity = draft.along(0, -draft.speed) if draft.speed else None
    upper = draft.line(
        draft.at(offset - half[0], height, -half[1]), draft.at(offset + half[0], height, half[1]),
        n, velocity=velocity,
    )  # fmt: skip
    # What stops a rope of half the length in a crossing, where the penetration is e, by
    # 4/3 sqrt(2 d) k e^(3/2) / sin(angle) over e; for a tenth of the radius, or less.
    e, d = SINKING * draft.radius, 2 * draft.radius
    square = draft.speed**2 + 2 * draft.closing * draft.gap
    energy = 0.5 * draft.density * draft.section.area * min(length, 20 * d) * square
    rest = draft.weight * length * e
    needed = max(energy, rest) * math.sin(angle) / (8 / 15 * math.sqrt(2 * d) * e**2.5)
    stiffness = float(needed * 10 ** rng.uniform(-0.3, 1))
    options = {"radius": draft.radius} if draft.needs_radius else {}
    options |= draft.draw_friction(square)
    options = draft.draw_law(options, 0.5 * draft.density * draft.section.area / stiffness)
    draft.contacts.append(draft.scene.contact(lower, upper, stiffness=stiffness, **options))
    draft.words |= {"n": n, "stiffness": stiffness, "angle": angle, **options}
    return draft.draw_duration(3)


def bend(draft):
    """Bend a rope around a bar, another beam, by half a turn or more, and pull both ends."""
    rng, length, radius = draft.rng, draft.length, draft.radius
    thickness = radius * float(10 ** rng.uniform(-0.2, 0.8))
    if draft.needs_radius:  # a contact has one radius, which is then that of the bar too
        thickness = radius
    draft.gap = radius * float(rng.choice([0.0, 0.02, 0.2]))
    size, angle = thickness + draft.gap, math.pi * float(rng.uniform(0.8, 1.4))
    bar = draft.scene.add_beam(
        "thin", draft.at(0, 0, -4.0 * (size + radius)), draft.at(0, 0, 4.0 * (size + radius)),
        int(rng.integers(2, 12)), ancf.Circle(2.0 * thickness), ancf.Material(2e11, 7800.0),
    )  # fmt: skip
    draft.scene.clamp(bar.start)
    draft.scene.clamp(bar.end)
    draft.keep(bar)
    draft.element, draft.options = "thin", {}
    rope, back, forth = arc(draft, size, angle)
    reach = size + radius
    # At least what holds the rope bent, and at most a hundredth of stretch.
    bending = draft.modulus * draft.section.inertia_z / reach**2
    force = min(
        max(bending, draft.weight * length) * float(10 ** rng.uniform(0.0, 1.0)),
        0.01 * draft.modulus * draft.section.area,
    )
    duration = math.sqrt(length / GRAVITY) * float(rng.uniform(0.1, 0.5))
    draft.pull(rope.start, force * back, 0.3 * duration)
    draft.pull(rope.end, float(rng.uniform(0.9, 1.0)) * force * forth, 0.3 * duration)
    options = {"radius": radius} if draft.needs_radius else {}
    if draft.needs_radius or rng.random() < 0.5:
        options["stiffness"] = (
            2.0 * force / (REST * radius * reach) * float(10 ** rng.uniform(0, 1))
        )
    options |= draft.draw_friction(GRAVITY * length, slips=rng.random() < 0.4)
    draft.contacts.append(draft.scene.contact(bar, rope, **options))
    draft.words |= {"thickness": thickness, "force": force, **options}
    return duration


def net(draft):
    """Let a small net fall on a ball."""
    rng, length = draft.rng, draft.length
    side, size = int(rng.integers(3, 5)), float(length * rng.uniform(0.3, 0.6))
    nodes, edges, _ = grid(side)
    places = (nodes / (side - 1) - 0.5) * length
    least = math.ceil(1.1 * length / (side - 1) / (QUARTER * size))
    height = size + draft.radius + draft.gap
    points = [draft.at(x, height, z) for x, z in places]
    velocity = draft.along(0, -draft.speed) if draft.speed else None
    mesh = draft.keep(
        draft.scene.add_mesh(
            points, edges, draft.element, draft.section, draft.material,
            n_elements=max(least, int(rng.integers(1, 3))), velocity=velocity, **draft.options,
        )
    )  # fmt: skip
    draft.touch(mesh, ancf.Ball(draft.at(0.02 * length, 0, 0.03 * length), size))
    draft.words |= {"side": side}
    return draft.draw_duration(3)


PARTS = {
    "fall": fall, "hang": hang, "wrap": wrap, "pulley": pulley, "throw": throw, "ropes": ropes,
    "net": net, "bend": bend,
}  # fmt: skip
