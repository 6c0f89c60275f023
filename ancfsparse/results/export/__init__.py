"""Files written from solutions: HDF5, VTKHDF and CSV; tables of pandas and xarray; reports."""

from typing import TYPE_CHECKING, Any

from ancfsparse.on_demand import on_demand
from ancfsparse.scene import Scene

if TYPE_CHECKING:
    from ancfsparse.results.export.csv_table import write_csv as write_csv
    from ancfsparse.results.export.gltf import write_gltf as write_gltf
    from ancfsparse.results.export.hdf5_writer import Writer as Writer
    from ancfsparse.results.export.labelled_tables import (
        make_dataset as make_dataset,
        make_frame as make_frame,
    )
    from ancfsparse.results.export.report.live_view import LiveView as LiveView
    from ancfsparse.results.export.report.notebook import (
        show_run as show_run,
        show_scene as show_scene,
    )
    from ancfsparse.results.export.report.report import write_report as write_report
    from ancfsparse.results.export.vtkhdf import (
        write_motion as write_motion,
        write_vtk as write_vtk,
    )

__getattr__ = on_demand(
    __name__,
    {
        "csv_table": "write_csv",
        "gltf": "write_gltf",
        "hdf5_writer": "Writer",
        "labelled_tables": "make_dataset make_frame",
        "report.live_view": "LiveView",
        "report.notebook": "show_run show_scene",
        "report.report": "write_report",
        "vtkhdf": "write_motion write_vtk",
    },
)


def _show(scene: Scene) -> str | None:
    """Return the picture of a scene for a notebook; scenes are below results."""
    draw: Any = __getattr__("show_scene")
    text: str | None = draw(scene)
    return text


Scene.show = _show
