"""Files written from solutions: HDF5, VTKHDF and CSV; tables of pandas and xarray."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.results.export.csv_table import write_csv
    from ancfsparse.results.export.hdf5_writer import Writer
    from ancfsparse.results.export.labelled_tables import make_dataset, make_frame
    from ancfsparse.results.export.recoverable_writer import RecoverableWriter
    from ancfsparse.results.export.vtkhdf import write_motion, write_vtk

__all__ = [
    "RecoverableWriter",
    "Writer",
    "make_dataset",
    "make_frame",
    "write_csv",
    "write_motion",
    "write_vtk",
]

__getattr__ = on_demand(
    __name__,
    {
        "csv_table": "write_csv",
        "hdf5_writer": "Writer",
        "labelled_tables": "make_dataset make_frame",
        "recoverable_writer": "RecoverableWriter",
        "vtkhdf": "write_motion write_vtk",
    },
)
