"""Saving of completed runs: every k-th state, points or a file.

A run that a plan has made already, equilibria and sums of modes are saved after they are completed,
so that no run is repeated.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ancfsparse.checks import check_count, check_flag
from ancfsparse.plans.execution.plan_data import PlanData
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod, Statics
from ancfsparse.results import Trajectory
from ancfsparse.results.solutions.selected_states import select_states
from ancfsparse.solve.preparation.threads import check_threads
from ancfsparse.solve.stepping.state_recorder import RunStorage, check_nodes, check_output

# Arguments of `simulate` that do not change the states.
SAVING = frozenset({"save_every", "save_nodes", "output", "progress", "threads"})
# Those for which all states must be complete until their range is compared with the trial runs.
PARTIAL = frozenset({"save_nodes", "output"})


def split_options(
    plan: PlanData, options: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the arguments of `simulate` for the run of a plan, and those for saving it later.

    Raises
    ------
    InputError
        If an argument for saving is invalid.
    """
    if "save_every" in options:
        options = {**options, "save_every": check_count("save_every", options["save_every"])}
    check_nodes(options.get("save_nodes"))
    check_output(options.get("output"))
    check_flag("progress", options.get("progress", False))
    check_threads(options.get("threads", 1))
    later: frozenset[str] = frozenset()
    if _has_result(plan, options):
        later = SAVING
    elif plan.t_end is None:
        later = SAVING - Statics.options
    elif isinstance(plan.integrator, SolutionMethod):
        later = SAVING - plan.integrator.options
    elif options.get("save_nodes") is not None:
        later = PARTIAL
    now = {name: value for name, value in options.items() if name not in later}
    return now, {name: value for name, value in options.items() if name in later}


def _has_result(plan: PlanData, options: Mapping[str, Any]) -> bool:
    """Return True if one of the trial runs is the run with these options."""
    if plan.result is None or not options.keys() <= SAVING:
        return False
    saved = plan.result.settings.get("save_every", 1)
    if "save_every" not in options:
        return bool(saved <= plan.save_every)
    return bool(options["save_every"] % saved == 0)


def save_run(run: Trajectory, options: Mapping[str, Any]) -> Trajectory:
    """Return a completed run with the selected states and points, or in a file."""
    if "save_every" in options:
        saved = run.settings.get("save_every", 1)
        n = len(run.t) - 1
        every = min(options["save_every"], saved * max(n, 1))
        rows = np.append(np.arange(0, n, every // saved), n)
        settings = {**run.settings, "save_every": every}
        run = select_states(run, rows, settings=settings, ending=run.last)
    nodes, output = options.get("save_nodes"), options.get("output")
    if nodes is None and output is None:
        return run
    settings = dict(run.settings)
    if "integrator" not in settings:  # equilibria do not begin at the stress-free shape
        settings["t_start"] = float(run.t[0])
    storage = RunStorage(run.system, len(run.t), nodes, output, settings)
    with storage.open() as recorder:
        q, v, a = (np.asarray(table) for table in (run.q, run.v, run.a))
        recorder.append(run.t, q, v, a, run.lam, run.internal)
        recorder.finish(run.stats, run.last)
    return storage.trajectory()
