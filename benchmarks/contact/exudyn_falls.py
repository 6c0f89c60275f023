"""A planar cable in Exudyn that falls on a drum, with its ObjectContactFrictionCircleCable2D."""

from __future__ import annotations

import time

from ancfsparse.scene import Circle, Scene
from benchmarks.contact import falls
from benchmarks.other_codes.exudyn import Model, Setting

SETTINGS = (
    Setting("Exudyn, modified Newton", 0.5, "EigenSparse", True, spectral_radius=0.5),
    Setting("Exudyn, full Newton", 0.0, "EigenSparse", True, spectral_radius=0.5),
)
SEGMENTS = 3  # of contact in each element, as many as we have points


def run_exudyn_fall(setting: Setting, dt: float) -> falls.Fall:
    """Run the fall on the drum.

    Raises
    ------
    ExudynError
        If its solver gives up.
    """
    free = Scene((0.0, -falls.GRAVITY))
    free.add_beam(
        "thin",
        (-falls.MIDDLE, falls.start_height(False)),
        (falls.LENGTH - falls.MIDDLE, falls.start_height(False)),
        falls.ELEMENTS,
        Circle(2.0 * falls.RADIUS),
        falls.MATERIAL,
    )
    model = Model(free)
    (nodes,) = model.nodes.values()
    _add_contact(model)
    for k in falls.WATCHED:
        model.watch(nodes[k])
    run = model.run(setting, falls.END, dt, falls.END, clock=time.process_time)
    return falls.Fall(run.seconds, run.tip[-1].reshape(-1, 2))


def _add_contact(model: Model) -> None:
    system, item = model.system, model.item
    ground = system.AddObject(item.ObjectGround(referencePosition=[0.0, 0.0, 0.0]))
    centre = system.AddMarker(item.MarkerBodyRigid(bodyNumber=ground))
    stiffness = falls.STIFFNESS * falls.LENGTH / (falls.ELEMENTS * SEGMENTS)
    for element in range(falls.ELEMENTS):
        shape = item.MarkerBodyCable2DShape(bodyNumber=element, numberOfSegments=SEGMENTS)
        history = [0.1] * SEGMENTS + [-2.0] * SEGMENTS + [0.0] * SEGMENTS
        node = item.NodeGenericData(
            initialCoordinates=history, numberOfDataCoordinates=len(history)
        )
        system.AddObject(
            item.ObjectContactFrictionCircleCable2D(
                markerNumbers=[centre, system.AddMarker(shape)],
                nodeNumber=system.AddNode(node),
                numberOfContactSegments=SEGMENTS,
                contactStiffness=stiffness,
                frictionStiffness=0.1 * stiffness,
                frictionCoefficient=falls.FRICTION,
                circleRadius=falls.OBSTACLE_RADIUS + falls.RADIUS,
            )
        )
