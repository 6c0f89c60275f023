"""Reasons for a plan, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

from ancfsparse.plans.discretization_error.error_model import ErrorModel
from ancfsparse.plans.discretization_error.mesh_grading import describe_gradings
from ancfsparse.plans.execution.plan_data import Prediction
from ancfsparse.plans.model_error.effects import SOURCE_NAMES
from ancfsparse.scene import Scene
from ancfsparse.scene.loads.attachment import ContactLaw


def reasons(
    scene: Scene,
    error_model: ErrorModel,
    predictions: Sequence[Prediction],
    integrator_given: bool,
) -> list[str]:
    """Return the reasons for the selected mesh and step, and warnings on their errors."""
    worst = max(predictions, key=lambda each: each.error / each.tolerance)
    largest = max(worst.sources, key=lambda name: worst.sources[name])
    source, unit = SOURCE_NAMES[largest], worst.goal.quantity.unit
    out = [
        f"the largest part of the error is that of the {source}, "
        f"{worst.sources[largest]:.1e} of {worst.tolerance:.1e} {unit}".rstrip()
    ]
    if error_model.model.gradings:
        out.append(describe_gradings(error_model.model.gradings))
    out += _estimate_reasons(error_model)
    if worst.error > worst.tolerance or error_model.is_bound:
        out += contact_reasons(scene)
    for body in scene.beams:
        if "n_elements" not in body.automatic:
            pairs = zip(error_model.given_mesh_errors, error_model.tolerances, strict=True)
            word = "above" if max(each / tolerance for each, tolerance in pairs) > 1.0 else "below"
            out.append(
                f"mesh of {body.name} given: the error of given meshes is predicted to be "
                f"{max(error_model.given_mesh_errors):.1e}, {word} the tolerance"
            )
    if error_model.fixed_steps is not None:
        out.append("step given")
    if integrator_given:
        out.append("integrator given")
    for each in predictions:
        if each.floor > each.tolerance:
            name, own_unit = each.goal.quantity.name, each.goal.quantity.unit
            out.append(
                f"converged elements differ by about {each.floor:.1e} {own_unit} in the {name}, "
                "because they define bending and stretch in several ways: no model guarantees "
                f"{each.tolerance:.1e} {own_unit}".rstrip()
            )
    if any(each.error > each.tolerance for each in predictions):
        out.append(
            f"the tolerance is not met: the largest remaining error, "
            f"{worst.sources[largest]:.1e} {unit}".rstrip()
            + f", is that of the {source}, which automatic meshes and steps cannot reduce further"
        )
    return out


def contact_reasons(scene: Scene) -> list[str]:
    """Return a sentence on each contact, for errors that do not decrease as in smooth motions."""
    return [
        f"where {contact.what} begins or ends, quantities are not differentiable functions of "
        "mesh, step and data, so their errors need not decrease with the theoretical order, and "
        "small changes of the data can have large effects: request quantities before an impact or "
        "at rest, or damp the motion"
        for contact in scene.attachments
        if isinstance(contact, ContactLaw)
    ]


def _estimate_reasons(error_model: ErrorModel) -> list[str]:
    """Return sentences on the estimates of mesh and steps, and on the confirmation run."""
    if error_model.is_bound:
        return [
            "complete motions do not converge as steps are halved, as after load jumps; the "
            "quantities do as mesh and steps are refined together, by order 1 or less, so errors "
            "are bounds from four motions"
        ]
    out = []
    for name, part in (("mesh size", error_model.mesh), ("step size", error_model.time)):
        if part is not None and not part.is_asymptotic:
            reserve = (
                "" if error_model.selected else "; a quarter of the tolerance is kept in reserve"
            )
            out.append(
                f"the trial runs do not show the theoretical convergence order in the {name}; the "
                f"smaller of observed and theoretical order is used{reserve}"
            )
    if error_model.selected is not None and error_model.optimal_excess <= 1.0:
        out.append("the final run agrees with the error estimate from the trial runs")
    return out
