"""The error of the mesh: the same steps with more elements, until that is enough."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

from ancfsparse.errors import InputError, StepError
from ancfsparse.plans.discretization_error.residual_correction import corrections, of_corrections
from ancfsparse.plans.discretization_error.richardson import Estimate, estimate
from ancfsparse.plans.models.model import Model, spread
from ancfsparse.plans.trial_runs.trial_runs import Pilot, Pilots, distances, tolerances
from ancfsparse.scene import Scene

# Elements on the longest beam of the coarsest mesh, and how many times as many each next has.  On
# four, the motion of the paper's pendulum is so rough that shorter steps do not converge.
COARSEST, GROWTH = 8.0, 1.5
MOST_MESHES = 12
# An equilibrium is sought on so many times as many elements next, if these are needed.
FURTHEST = 3.0
# How often nodes are spread by what pilots show.
MOST_GRADES = 2
# An error so many times the one asked for can be extrapolated from: if its order has shown, if
# another has shown, and if two meshes cannot show it.  `confirmed` looks whether it is right.
FAR, NEAR, SMALL = 12.0, 1.0, 0.4
SOLVER_NOISE = 1e-7


@dataclass(frozen=True)
class MeshError:
    """What pilot runs on several meshes have shown.

    Attributes
    ----------
    estimates : tuple of Estimate
        For every quantity, by the number of elements.
    runs : tuple of Pilot
        With ascending numbers of elements.
    """

    estimates: tuple[Estimate, ...]
    runs: tuple[Pilot, ...]


def elements_of(pilot: Pilot) -> int:
    """Return the number of elements of the beams whose mesh is open."""
    scene = pilot.run.system.scene
    return sum(scene.body(name).n_elements for name in pilot.model.counts)


def mesh_error(
    pilots: Pilots,
    model: Model,
    finest: float,
    steps: int,
    order: int,
    affordable: Callable[[Pilot], bool],
    graded: Callable[[MeshError, bool], Model | None] = lambda found, done: None,
) -> MeshError:
    """Refine the mesh until the error of every quantity can be predicted.

    Where a pilot shows that fewer graded elements will do, these are refined in place of others.

    Parameters
    ----------
    pilots : Pilots
        Runs.
    model : Model
        Its elements.
    finest : float
        Elements on the longest beam of the coarsest mesh.
    steps : int
        Number of steps, for which the motions on all meshes have about the same error.
    order : int
        Order of positions in the length of the elements.
    affordable : callable
        Whether a finer mesh than this last one may still be tried.
    graded : callable, optional
        Returns the model with other grades where they pay, else None, by what runs have shown, and
        by whether no more would be made.

    Raises
    ------
    StepError
        If a run on a finer mesh needs shorter steps than `time_error` has found.
    """
    runs: list[Pilot] = []
    best: MeshError | None = None
    left = MOST_GRADES
    while len(runs) < MOST_MESHES:
        try:
            run = _run(pilots, model.with_counts(spread(pilots.scene, finest)), steps)
        except (InputError, StepError):
            if best is None:
                raise
            return best  # only graded meshes fail
        if not runs or elements_of(run) > elements_of(runs[-1]):
            runs.append(run)
        finest *= GROWTH
        if len(runs) < 2 and pilots.t_end is not None:
            continue
        estimates = mesh_estimates(pilots, runs, order)
        if estimates is None:
            continue
        found = MeshError(estimates, tuple(runs))
        enough = _enough(pilots, runs, found.estimates)
        done = enough or (len(runs) > 2 and not affordable(runs[-1]))
        direct = pilots.t_end is None and corrections(pilots, run) is not None
        seen = len(runs) > 2 or (direct and len(runs) > 1)
        other = graded(found, done) if left and (done or seen) else None
        if other is not None:
            best = found if best is None else min(best, found, key=partial(_price, pilots))
            left, model, finest, runs = left - 1, other, finest / GROWTH**2, []
        elif done:
            break
        elif direct:  # the next pilot may be the answer
            more = _price(pilots, found) / elements_of(run)
            finest = max(finest, min(more, FURTHEST) * finest / GROWTH)
    return found if best is None else min(found, best, key=partial(_price, pilots))


def _price(pilots: Pilots, found: MeshError) -> float:
    """Return how many elements are predicted to reach the errors asked for."""
    asked = tolerances(pilots.wanted, found.runs[-1])
    return max(each.needed(most) for each, most in zip(found.estimates, asked, strict=True))


def _run(pilots: Pilots, model: Model, steps: int) -> Pilot:
    run = pilots.run(model, steps)
    if run is None:
        assert pilots.failure is not None
        raise pilots.failure
    return run


def mesh_estimates(
    pilots: Pilots, runs: Sequence[Pilot], order: int
) -> tuple[Estimate, ...] | None:
    """Estimate the error of meshes for every quantity; None if there are too few."""
    known = corrected_estimates(pilots, runs[-2:], order) if pilots.t_end is None else None
    if known is not None or len(runs) < 2:
        return known
    orders, noises = _expected(pilots, runs[-1], order)
    last = runs[-3:]
    counts = [elements_of(run) for run in last]
    apart = [distances(pilots.wanted, a, b) for a, b in pairwise(last)]
    out = []
    for far, power, noise in zip(zip(*apart, strict=True), orders, noises, strict=True):
        out.append(estimate(counts, far, power, noise))
    return tuple(out)


def corrected_estimates(
    pilots: Pilots, runs: Sequence[Pilot], order: int
) -> tuple[Estimate, ...] | None:
    """Estimate the error of the last of one or two meshes of an equilibrium by corrections.

    None where a correction does not show it.
    """
    known = [each for each in (corrections(pilots, run) for run in runs) if each is not None]
    if len(known) < len(runs):
        return None
    counts = [elements_of(run) for run in runs]
    changes = zip(*known, strict=True)
    pairs = zip(changes, *_expected(pilots, runs[-1], order), strict=True)
    return tuple(of_corrections(counts, *each) for each in pairs)


def _expected(pilots: Pilots, run: Pilot, order: int) -> tuple[list[int], list[float]]:
    """Return the order in which every quantity converges, and its rounding [its unit]."""
    pairs = list(zip((each.quantity for each in pilots.wanted), run.histories, strict=True))
    orders = [quantity.order(order) for quantity, _ in pairs]
    return orders, [SOLVER_NOISE * quantity.size(history) for quantity, history in pairs]


def given_error(pilots: Pilots, finer: Scene, model: Model, steps: int, order: int) -> list[float]:
    """Estimate the error of meshes that were given, by one run with twice as many elements.

    Parameters
    ----------
    pilots, model, steps, order
        As in `mesh_error`.
    finer : Scene
        The scene with every given element divided into two.

    Returns
    -------
    list of float
        The error of every quantity [its unit].
    """
    other = Pilots(
        finer,
        pilots.t_end,
        pilots.wanted,
        pilots.integrator,
        pilots.base,
        pilots.start,
        bill=pilots.bill,
    )
    coarse, fine = _run(pilots, model, steps), _run(other, model, steps)
    pilots.seconds += other.seconds
    apart = distances(pilots.wanted, coarse, fine)
    orders = [each.quantity.order(order) for each in pilots.wanted]
    # The difference is e(n) - e(2 n) = e(n) (1 - 2^-p).
    return [d / (1.0 - 2.0**-p) for d, p in zip(apart, orders, strict=True)]


def _enough(pilots: Pilots, runs: Sequence[Pilot], estimates: Sequence[Estimate]) -> bool:
    asked = tolerances(pilots.wanted, runs[-1])
    return all(
        each.careful <= (FAR if each.settled else NEAR if each.seen else SMALL) * most
        for each, most in zip(estimates, asked, strict=True)
    )
