"""Files written from solutions: HDF5, VTKHDF and CSV; tables of pandas and xarray; reports."""

from typing import TYPE_CHECKING, Any

from ancfsparse.on_demand import on_demand
from ancfsparse.scene import Scene

if TYPE_CHECKING:
    from ancfsparse.results.export.csv_table import write_csv
    from ancfsparse.results.export.gltf import write_gltf
    from ancfsparse.results.export.hdf5_writer import Writer
    from ancfsparse.results.export.labelled_tables import make_dataset, make_frame
    from ancfsparse.results.export.report.live_view import LiveView
    from ancfsparse.results.export.report.notebook import show_run, show_scene
    from ancfsparse.results.export.report.report import write_report
    from ancfsparse.results.export.vtkhdf import write_motion, write_vtk

__all__ = [
    "LiveView",
    "Writer",
    "make_dataset",
    "make_frame",
    "show_run",
    "show_scene",
    "write_csv",
    "write_gltf",
    "write_motion",
    "write_report",
    "write_vtk",
]

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
