"""Random runs with contact: Newton does no better, no energy is gained, and bodies keep apart."""

import warnings

import numpy as np

import ancfsparse as ancf
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.force_elements.beam_contacts import BeamContact
from ancfsparse.scene.force_elements.contacts import Contact
from tests.soak.contacts.parts import recorded_parts, with_parts
from tests.soak.contacts.scenes import draw
from tests.soak.contacts.sides import away, passes_base, passes_between
from tests.soak.report import Report
from tests.soak.scenes import draw_integrator, draw_solver
from tests.soak.trials.spoiled_calls import MAX_LETTERS

MAX_GAIN = 0.01  # energy above the supplied work, over the energy exchanged
# Error of the balance with `EnergyMomentum`, over the energy exchanged: 3e-8 in 42 runs.
MAX_BALANCE_ERROR = 1e-6
MAX_DEPTH = 1.0  # penetration over the radius
MAX_FRICTION_ERROR = 1e-9  # of friction above mu p, relative
ROUNDING = 1e-14  # of the energy, over the largest of all terms
PERTURBATION = 1e-9  # relative change of the step between neighbouring runs
NEIGHBOURS = 4  # of them on either side
# Distance of an axis from its polygon, over the radius.  Two axes that are inside each other by
# more than MAX_DEPTH are a find anyway, and others are further apart than both errors.
CHORD_ERROR = 0.25
MOST_CHORDS = 256  # of an element
PLACES = (0.001, 0.25, 0.5, 0.75, 0.999)  # on each element, where its side is followed


def run(seed, index, has_laws=True):
    """Run a random scene with contacts by a random integrator and solver.

    Some contacts have restitution or static friction, or else none has.
    """
    rng = np.random.default_rng([seed, index])
    drawn = draw(rng, np.random.default_rng([seed, index, 1]) if has_laws else None)
    integrator, solver = draw_integrator(rng), draw_solver(rng)
    if drawn.is_explicit:
        integrator, solver = drawn.explicit, "auto"
    return attempt(drawn, integrator, solver)


def run_bend(seed, index):
    """Run a rope that is bent around a bar by a random integrator and solver."""
    rng = np.random.default_rng([seed, index])
    drawn = draw(rng, layout="bend")
    integrator, solver = draw_integrator(rng), draw_solver(rng)
    if drawn.is_explicit:
        integrator, solver = drawn.explicit, "auto"
    return attempt(drawn, integrator, solver)


def attempt(drawn, integrator, solver):
    """Run a scene and judge how that ends."""
    tried = f"{integrator!r}, {solver!r}, {drawn.words}"
    try:
        with recorded_parts() as parts:
            path, sank = simulate(drawn, integrator, solver)
    except ancf.StepError as stop:
        finds, word = judge_sentence(stop), type(stop).__name__
        if stop.trajectory is not None and len(stop.trajectory.t) > 1:
            whole = with_parts(stop.trajectory, parts)
            finds += judge_contacts(drawn, stop.trajectory, whole)
        if solver != ancf.Newton() and finishes(drawn, integrator, ancf.Newton()):
            if fails_by_chance(drawn, integrator, solver):
                return Report(f"failed by chance ({word})", finds, tried)
            finds.append(f"Newton finishes it, and it ended with: {stop}")
        return Report(f"failed ({word})", finds, tried)
    except ancf.AncfError as refused:
        return Report(f"refused ({type(refused).__name__})", judge_sentence(refused), tried)
    whole = with_parts(path, parts)
    gain, deepest = gain_of(drawn, whole), deepest_of(drawn, path)
    finds = judge(drawn, path, whole) + ([] if sank else judge_axes(drawn, path))
    ratios = {"energy gained over that exchanged": gain, "penetration over radius": deepest}
    return Report(outcome_of(drawn, path, sank), finds, tried, ratios)


def outcome_of(drawn, path, sank):
    """Return the outcome of a run that finished, in a few words."""
    if sank:
        return "sank in"
    return "finished" if any(touches(each, path) for each in drawn.contacts) else "apart"


def judge_axes(drawn, path):
    """Return a find for each axis that was inside an obstacle without a warning."""
    obstacles = [each for each in drawn.contacts if isinstance(each, Contact)]
    deepest = [depths(each, path, points_along(each.bodies[0])).max() for each in obstacles]
    return [
        f"an axis is {depth:.2f} radii inside {each.what} without a warning"
        for depth, each in zip(deepest, obstacles, strict=True)
        if depth > MAX_DEPTH
    ]


def touches(contact, path):
    """Return True if a force acted: by a damped scheme in the step before the touch too."""
    if isinstance(contact, BeamContact):
        return path.contact_force(contact).penetration.max() > 0.0
    depth = depths(contact, path, contact.points)
    return bool((depth > 0.0).any() or (depth[1:] + np.diff(depth, axis=0) > 0.0).any())


def simulate(drawn, integrator, solver, moved=1.0):
    """Return a run with steps moved by a factor, and whether it warned that a body sank in."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        path = ancf.simulate(
            drawn.scene, drawn.t_end * moved, drawn.dt * moved, integrator=integrator,
            solver=solver, max_halvings=drawn.max_halvings,
        )  # fmt: skip
    sank = [each for each in caught if issubclass(each.category, ancf.PenetrationWarning)]
    for each in caught:
        if each not in sank:
            warnings.warn_explicit(each.message, each.category, each.filename, each.lineno)
    return path, bool(sank)


def finishes(drawn, integrator, solver, moved=1.0):
    """Return True if a solver finishes the run, with the same step or one that is moved."""
    if drawn.is_explicit:
        return False  # there is no other solver
    try:
        simulate(drawn, integrator, solver, moved)
    except ancf.StepError:
        return False
    return True


def fails_by_chance(drawn, integrator, solver):
    """Return True if rounding decides which run fails, by the rule of docs/stability.md.

    Newton does not finish all runs whose steps differ by billionths, and the solver at least half
    as many.
    """
    moves = [1.0 + k * PERTURBATION for k in range(-NEIGHBOURS, NEIGHBOURS + 1) if k]
    by_newton = sum(finishes(drawn, integrator, ancf.Newton(), moved) for moved in moves)
    by_solver = sum(finishes(drawn, integrator, solver, moved) for moved in moves)
    return by_newton < len(moves) and by_solver >= 0.5 * by_newton


def judge_sentence(error):
    text = str(error)
    is_sentence = "\n" not in text and 10 < len(text) < MAX_LETTERS
    return [] if is_sentence else [f"its error is no sentence: {text[:80]!r}"]


def judge(drawn, path, whole=None):
    """Return the errors of a run that finished, with its states inside divided steps if given."""
    if not np.isfinite(path.q[:]).all():
        return ["its states are not finite"]
    finds = judge_contacts(drawn, path, whole or path)
    if (gain := gain_of(drawn, whole or path)) > MAX_GAIN:
        finds.append(f"it had {gain:.2g} of the energy exchanged more than was given")
    energy = path.energy
    is_exact = path.settings["integrator"] == repr(ancf.EnergyMomentum())
    # Dissipation and the work of forces are integrated over the saved states.
    if is_exact and not drawn.pulls and not energy.dissipated.any():
        error = np.abs(energy.total - energy.total[0] - energy.work + energy.lost).max()
        error -= ROUNDING * largest_energy(drawn, energy)
        if error > MAX_BALANCE_ERROR * exchanged_energy(energy):
            finds.append(f"its energy balance has an error of {error:.2g} J")
    return finds


def gain_of(drawn, path):
    """Return the largest energy above the one that was given, over the energy exchanged [-]."""
    energy = path.energy
    rounding = ROUNDING * largest_energy(drawn, energy)
    gain = np.max(energy.total - energy.total[0] - given_work(drawn, path)) - rounding
    exchanged = exchanged_energy(energy)
    return float(gain / exchanged) if exchanged > 0.0 else max(0.0, float(gain))


def largest_energy(drawn, energy):
    """Return the size of the terms whose differences energies are [J]."""
    columns = energy.kinetic, energy.elastic, energy.potential, energy.work
    stiff = sum(b.material.youngs_modulus * b.section.area * b.lengths.sum() for b in drawn.beams)
    return max(np.abs(each).max() for each in columns) + stiff


def exchanged_energy(energy):
    """Return the largest energy that motion, strain, gravity and loads exchange [J]."""
    others = energy.elastic, energy.potential, energy.work
    return max(energy.kinetic.max(), *(np.abs(each - each[0]).max() for each in others))


def given_work(drawn, path):
    """Return the largest possible work of forces and turning drums up to each time [J].

    Friction on fixed obstacles and between bodies gives none.
    """
    work = np.zeros(len(path.t))
    for node, signal in drawn.pulls:
        force = np.array([signal(t) for t in path.t])
        moved = np.diff(path.position(node), axis=0)
        work[1:] += np.cumsum((0.5 * (force[1:] + force[:-1]) * moved).sum(axis=1))
    for contact in drawn.contacts:
        if not isinstance(contact, Contact) or not contact.obstacle.spin.any():
            continue
        power = surface_power(contact, path)
        work[1:] += np.cumsum(np.diff(path.t) * np.maximum(power[1:], power[:-1]))
    return work


def surface_power(contact, path):
    """Return the largest possible power of friction on the surface of a drum, (k,) [W].

    The pressure k e, with e of the states or, in schemes other than energy-momentum, as damped in
    an impact (docs/theory.md), acts against the sliding velocity; what only takes energy counts as
    none.  Bristles can act in any direction, also in that of the surface.
    """
    vectors = away(contact.obstacle, vectors_from(contact, path, contact.points))
    sizes = np.linalg.norm(vectors, axis=-1)
    surface = vectors @ contact.obstacle.spin.T
    sliding = positions(path, contact.points, path.v) - surface
    normals = vectors / sizes[..., None]
    sliding = sliding - (sliding * normals).sum(axis=-1)[..., None] * normals
    depths = contact.obstacle.radius + contact.radii[0] - sizes
    stiffness = part_of(contact, path).stiffness[0]
    mass = contact.bodies[0].material.density * contact.bodies[0].section.area
    ratio = 2.0 * np.diff(path.t) / (np.pi * np.sqrt(mass / stiffness))
    most = depths.copy()
    most[1:] = np.maximum(
        depths[1:], depths[1:] + np.minimum(1.0, ratio**2)[:, None] * np.diff(depths, axis=0)
    )
    pressure = stiffness * np.maximum(most, 0.0) * contact.weights
    if contact.sticks:
        along = np.linalg.norm(surface, axis=-1)
    else:
        speed = np.sqrt((sliding**2).sum(axis=-1) + contact.slip_speed**2)
        along = -(sliding * surface).sum(axis=-1) / speed
    largest = contact.static_friction * (1.0 + damped_share(contact.restitution))
    return (largest * pressure * np.maximum(along, 0.0)).sum(axis=1)


def damped_share(restitution):
    """Return the share of the pressure that a restitution adds to it, at most [-]."""
    return (1.0 - restitution**2) / (1.0 + restitution**2) if restitution else 0.0


def part_of(contact, path):
    """Return the part of the system of a run that is a contact."""
    parts = (each for each in path.system.contributions if hasattr(each, "contact"))
    return next(each for each in parts if each.contact is contact)


def judge_contacts(drawn, path, whole):
    """Return the errors of the contacts of a run, finished or not.

    Sides are followed from part to part of divided steps, as the way from one saved state to the
    next is not straight.
    """
    finds, deepest = [], deepest_of(drawn, path)
    if deepest > MAX_DEPTH and not all(is_announced(each, path) for each in drawn.contacts):
        finds.append(f"a body is {deepest:.3g} radii inside")
    for contact in drawn.contacts:
        forces = path.contact_force(contact)
        if isinstance(contact, BeamContact):
            allowed = CHORD_ERROR * min(contact.radii)
            one, other = (polygon(whole, each, allowed) for each in contact.bodies)
            if (k := passes_between(one, other)) is not None:
                finds.append(f"ropes pass through each other before t = {whole.t[k]:.6g} s")
            finds += judge_friction(forces.friction, contact.static_friction * forces.size, "N")
            continue
        # An end sinks into a plane by a part of an element (docs/limits.md), but no part of an axis
        # comes out of the other side of a round obstacle.
        is_plane = isinstance(contact.obstacle, ancf.HalfSpace)
        points = contact.points if is_plane else points_along(contact.bodies[0])
        vectors = vectors_from(contact, whole, points)
        if (k := passes_base(contact.obstacle, vectors)) is not None:
            noun = contact.obstacle.noun
            finds.append(f"the axis passes through the {noun} before t = {whole.t[k]:.6g} s")
        friction = np.linalg.norm(forces.friction, axis=2)
        finds += judge_friction(friction, contact.static_friction * forces.pressure, "N/m")
    return finds


def is_announced(contact, path):
    """Return True if a run warns that a given stiffness is too small for it."""
    if not isinstance(contact, Contact) or contact.stiffness is None:
        return False
    part = part_of(contact, path)
    limit = part.penetration_limit
    return limit is not None and not limit.allows(part.deepest_of_motion, at_rest=False)


def judge_friction(friction, most, unit):
    """Return an error if friction exceeds the given bounds."""
    excess = np.max(friction - most * (1.0 + MAX_FRICTION_ERROR))
    return [f"friction exceeds mu p by {excess:.3g} {unit}"] if excess > 0.0 else []


def deepest_of(drawn, path):
    """Return the largest penetration at points where forces act, over the radius [-]."""
    return float(
        max(
            path.contact_force(each).penetration.max() / min(each.radii)
            if isinstance(each, BeamContact)
            else depths(each, path, each.points).max()
            for each in drawn.contacts
        )
    )


def depths(contact, path, points):
    """Return the penetrations of points of an axis over the radius of its body, (k, n) [-]."""
    vectors = away(contact.obstacle, vectors_from(contact, path, points))
    is_plane = vectors.shape[-1] == 1
    distances = vectors[..., 0] if is_plane else np.linalg.norm(vectors, axis=-1)
    return 1.0 - (distances - contact.obstacle.radius) / contact.radii[0]


def points_along(body, places=PLACES):
    """Return points of a body in the order of its elements."""
    return [Point(body, e, x) for e in range(body.n_elements) for x in places]


def polygon(path, body, allowed):
    """Return points of an axis whose chords are off it by at most a length [m] in all states."""
    n = 4
    while True:
        places = np.linspace(PLACES[0], PLACES[-1], n + 1)
        points = positions(path, points_along(body, places))
        rows = points.reshape(len(points), body.n_elements, n + 1, -1)
        chords = 0.5 * (rows[:, :, :-2:2] + rows[:, :, 2::2])
        off = np.linalg.norm(rows[:, :, 1::2] - chords, axis=-1)
        # Half as long chords of a curve are off by a quarter.
        if 0.25 * off.max() <= allowed or n == MOST_CHORDS:
            return points
        n *= 2


def positions(path, points, states=None):
    """Return points of a run at all saved times, (k, n, dim) [m], or their velocities."""
    states = np.asarray(path.q if states is None else states)
    tables = [path.system.point(point) for point in points]
    return np.stack([states[..., where] @ weights for where, weights in tables], axis=1)


def vectors_from(contact, path, points):
    """Return the vectors from the base of an obstacle to points, (k, n, dim) [m]."""
    base = np.array(contact.obstacle.base)
    if contact.on is not None:
        base = positions(path, [contact.base_point])
    return positions(path, points) - base
