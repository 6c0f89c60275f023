"""The reasons for a plan, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

from ancfsparse.plans.discretization_error.error_model import Found
from ancfsparse.plans.discretization_error.mesh_grading import described as spread_by
from ancfsparse.plans.execution.plan_data import Prediction
from ancfsparse.plans.selection.element_hierarchy import NAMES
from ancfsparse.scene import Scene


def reasons(
    scene: Scene, found: Found, predictions: Sequence[Prediction], integrator_given: bool
) -> list[str]:
    """Explain what decided, in sentences."""
    out = []
    worst = max(predictions, key=lambda each: each.error / each.asked)
    largest = max(worst.sources, key=lambda name: worst.sources[name])
    out.append(
        f"the largest part of the error is that of the {NAMES[largest]}, "
        f"{worst.sources[largest]:.1e} of {worst.asked:.1e} {worst.wanted.quantity.unit}".rstrip()
    )
    if found.model.grades:
        out.append(spread_by(found.model.grades))
    for name, part in (("mesh", found.mesh), ("steps", found.time)):
        if found.is_bound:
            break
        if part is not None and not all(each.settled for each in part.estimates):
            reserve = "" if found.chosen else ", and half of the error stays in reserve"
            out.append(
                f"pilots of the {name} do not show the order of the method, so the more "
                f"pessimistic order is used{reserve}"
            )
    if found.is_bound:
        out.append(
            "whole motions do not approach each other as steps are halved, as after jumps; what is "
            "asked for does as mesh and steps are refined together, by order 1 or less, so errors "
            "are bounds that four motions show"
        )
    elif found.chosen is not None:
        out.append(
            "the run was made as the last pilot, and is as far from those before as foreseen"
        )
    for body in scene.beams:
        if "n_elements" not in body.automatic:
            share = max(each / most for each, most in zip(found.given, found.asked, strict=True))
            word = "above" if share > 1.0 else "below"
            out.append(
                f"mesh of {body.name} given: the error of given meshes is predicted to be "
                f"{max(found.given):.1e}, {word} what was asked for"
            )
    if found.fixed_steps is not None:
        out.append("step given")
    if integrator_given:
        out.append("integrator given")
    for each in predictions:
        unit = each.wanted.quantity.unit
        if each.floor > each.asked:
            out.append(
                f"elements that are all converged differ by about {each.floor:.1e} {unit} in the "
                f"{each.wanted.quantity.name}, because bending and stretch are measured in several "
                f"ways: no model here can promise {each.asked:.1e} {unit}".rstrip()
            )
    if any(each.error > each.asked for each in predictions):
        out.append(
            f"the error asked for is not reached: most of what is left, "
            f"{worst.sources[largest]:.1e} {worst.wanted.quantity.unit}".rstrip()
            + f", is that of the {NAMES[largest]}, and what is open cannot reduce it further"
        )
    return out
