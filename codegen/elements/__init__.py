"""The elements, one file each: coordinates, interpolation, energy."""

from collections.abc import Callable

from codegen.elements.l2t2 import l2t2
from codegen.elements.thin import thin
from codegen.fields import Element


def _table() -> dict[str, tuple[str, Callable[[], Element]]]:
    table: dict[str, tuple[str, Callable[[], Element]]] = {
        "l2t2": ("codegen/elements/l2t2.py", l2t2),
    }
    for dim, where in ((2, "planar"), (3, "spatial")):
        for strain in ("green", "biot"):
            table[f"thin_{where}_{strain}"] = (
                "codegen/elements/thin.py",
                lambda dim=dim, strain=strain: thin(dim, strain),
            )
    return table


ELEMENTS = _table()
"""Name of the module, the file that says what the element is, and how to build it."""
