"""Random runs: no raw error, energies as computed independently, no gain, no false alarm."""

import itertools

import numpy as np

import ancfsparse as ancf
from ancfsparse.system import System
from tests.integrators.linear_step import first_step, gain, linearized
from tests.soak.energies import energies, of_box
from tests.soak.exactly import gain_by_newton, gain_of_run
from tests.soak.report import Report
from tests.soak.scenes import draw, draw_integrator, draw_solver

# Sums of Newton's gains from perturbed states, where the first blames the run.  Rounding decides a
# step of which 8 of 60 perturbed ones had a solution without a gain, but 5 of the first 9.
PERTURBED = 40
PERTURBATION = 1e-9  # relative change of the step between neighbouring runs by Newton
PERTURBATIONS = 10  # neighbouring runs on either side
MAX_DIFFERENCE = 1e-9  # of energies from those computed here, over the largest
MAX_GAIN = 0.01  # energy above the supplied work, over the largest kinetic energy
ROUNDING = 1e-14  # of the energy, over the largest of all terms


def run(seed, index):
    """Run a random scene by a random integrator and solver; an alarm must be one for Newton too."""
    rng = np.random.default_rng([seed, index])
    return attempt(draw(rng), draw_integrator(rng), draw_solver(rng))


def attempt(drawn, integrator, solver):
    """Run a scene and judge how that ends."""
    tried = f"{integrator!r}, {solver!r}, {drawn.words}"
    try:
        path = ancf.simulate(
            drawn.scene, drawn.t_end, drawn.dt, integrator=integrator, solver=solver
        )
    except ancf.EnergyIncreaseError as stop:
        return Report("gained energy", alarm(drawn, integrator, stop), tried)
    except ancf.StepError:
        return Report("failed", [], tried)
    except ancf.AncfError as refused:
        return Report(f"refused ({type(refused).__name__})", [], tried)
    return Report("finished", judge(drawn, integrator, path), tried)


def alarm(drawn, integrator, stop):
    """Return the errors of a run that was stopped for its energy.

    It is wrong where the same steps, solved by Newton, do not gain too much.
    Corrections that wander where the matrix is indefinite end in one of several solutions, and
    rounding decides in which.  So what Newton gains then is the median over states shaken by it.
    And solutions of one step that differ by little more than is allowed are as good by any rule on
    energies: a run that has gained too much by such a step is wrongly stopped only if Newton
    finishes it, or a neighbouring one.
    """
    last, allowed = stop.when or stop.step, stop.limit * stop.exchanged

    def is_one_for(gain):
        return stop.gain - gain < allowed or gain > allowed

    gain = gain_by_newton(drawn, integrator, stop.trajectory, last)
    if is_one_for(gain):
        return []
    shaken = (np.random.default_rng(k) for k in range(PERTURBED))
    gains = [gain_by_newton(drawn, integrator, stop.trajectory, last, rng) for rng in shaken]
    gain = float(np.median([gain, *gains]))
    if is_one_for(gain):
        return []
    own = gain_of_run(drawn, integrator, stop.trajectory, last)
    if own > allowed and not finishes_by_newton(drawn, integrator):
        return []
    return [
        f"stopped for {stop.gain:.2g} J more than was given up to step {last}, of which "
        f"{allowed:.2g} J are allowed, and Newton's solutions of its steps have {gain:.2g} J more"
    ]


def finishes_by_newton(drawn, integrator):
    """Return True if Newton finishes the run or one whose step differs by billionths."""
    for k in range(-PERTURBATIONS, PERTURBATIONS + 1):
        moved = 1.0 + k * PERTURBATION
        try:
            ancf.simulate(
                drawn.scene,
                drawn.t_end * moved,
                drawn.dt * moved,
                integrator=integrator,
                solver=ancf.Newton(),
            )
        except ancf.StepError:
            continue
        return True
    return False


def judge(drawn, integrator, path):
    """Return the errors of a run that finished."""
    total, kinetic, finds = path.energy.total, path.energy.kinetic, []
    if drawn.cables:
        gravity = drawn.scene.gravity
        parts = [energies(path, beam, gravity) for beam in drawn.beams]
        parts += [of_box(path, body, gravity) for body in drawn.bodies]
        ours = np.sum([sum(each) for each in parts], axis=0)
        moving = np.sum([each[0] for each in parts], axis=0)
        # What is at rest holds the energy of rounding, strains of 1e-16.
        rounding = sum(b.length * b.material.youngs_modulus * b.section.area for b in drawn.beams)
        size = moving.max() + np.abs(ours).max() + 1e-20 * rounding
        apart = float(np.abs(ours - total).max() / size)
        if not apart < MAX_DIFFERENCE:
            finds.append(f"its energies differ by {apart:.2g} from those computed independently")
        total, kinetic = ours, moving
    if not np.isfinite(total).all():
        return [*finds, "its energies are not finite"]
    # Strain energies are those of strains that are differences of numbers of size one.
    size = np.abs(total).max() + sum(
        b.length * b.material.youngs_modulus * b.section.area for b in drawn.beams
    )
    gain = np.max(total - total[0] - largest_work(drawn, integrator, path)) - ROUNDING * size
    gain /= kinetic.max() if kinetic.max() > 0.0 else 1.0
    if gain > MAX_GAIN:
        finds.append(f"it ended with {gain:.2g} of its largest kinetic energy more than was given")
    return finds


def largest_work(drawn, integrator, path):
    """Return the largest possible work of the load up to each time [J].

    That is the work of the trapezoidal rule, half of a jump inside a step along the way of that
    step, what the scheme adds where the load turns, and what it adds in the first step.  From rest
    this is the gain of the scheme in the linearized system, written independently.  Otherwise it
    is the work that the trapezoidal rule omits of a load that begins with a rate: where that load
    alone moves its node, by t^3, it does 3/4 of its change along the way of the step, not 1/2.
    """
    work = np.zeros(len(path.t))
    if drawn.force is None:
        return work
    force = np.array([drawn.force(t) for t in path.t])
    moved = np.diff(path.position(drawn.node), axis=0)
    steps = (0.5 * (force[1:] + force[:-1]) * moved).sum(axis=1)
    if drawn.words["load"] in ("jump", "pulse"):
        steps += 0.5 * np.abs((np.diff(force, axis=0) * moved).sum(axis=1))
    if drawn.words["motion"] == "rest":
        steps[0] += max(0.0, gain_from_rest(drawn, integrator))
    else:
        steps[0] += 0.25 * abs((force[1] - force[0]) @ moved[0])
    work[1:] = np.cumsum(steps) + work_of_turns(integrator, force, moved)
    return work


def gain_from_rest(drawn, integrator):
    """Return what a scheme adds to the work of the trapezoidal rule in its first step [J].

    A beam that falls against a growing load has 5 % of its largest kinetic energy more than its
    work after a step of 0.6 rad with rho_inf = 0, and loses it in the next step.
    """
    if integrator.keeps_energy:
        return 0.0
    linear = linearized(System(drawn.scene), drawn.dt)
    return gain(linear, first_step(linear, integrator, drawn.dt))


def work_of_turns(integrator, force, moved):
    """Return the work that a scheme with damping may add to that of the trapezoidal rule [J].

    With D for differences over a step, a linear vibration without damping of its own has

        DE = Dq.f + Dq.M [(1/2 - alpha_f) d + epsilon Db] - (beta - gamma/2) h^2 [D(b.M b)/2 + ...],

    with f the mean load, epsilon = gamma - 1/2 + alpha_m - alpha_f and d = Da - Db.  The last term
    takes energy but for what it gives back.  By the equation of b, alpha_m b0 + (1 - alpha_m) b1 =
    alpha_f a0 + (1 - alpha_f) a1, what b lacks follows the change of Da,

        (1 - alpha_m) d1 = (alpha_f - alpha_m) (Da1 - Da0) - alpha_m d0,

    and in slow vibrations M a is the load: d follows its second differences, and the work is at
    most |1/2 - alpha_f| |d| |Dq| and epsilon |Df| |Dq|, which turns with the load too.  It is zero
    for the trapezoidal rule and falls with the steps; where h omega is not small a vibration
    answers with up to four times as much of the first.  Signs change from step to step, so squares
    add up.  The start knows the rate of the load in the first step, so nothing turns there.
    """
    m, f = integrator.alpha_m, integrator.alpha_f
    lag, kept = abs((0.5 - f) * (f - m) / (1.0 - m)), abs(m / (1.0 - m))
    share = 4.0 * lag + abs(integrator.gamma - 0.5 + m - f)
    turns = np.abs(np.diff(force, n=2, axis=0, prepend=2.0 * force[:1] - force[1:2]))
    for before, now in itertools.pairwise(turns):
        now += kept * before
    return share * np.sqrt(np.cumsum((turns * np.abs(moved)).sum(axis=1) ** 2))
