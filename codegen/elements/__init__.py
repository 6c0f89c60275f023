"""The elements, one file each: coordinates, interpolation, energy."""

from collections.abc import Callable
from functools import partial

from codegen.declarations.fields import Element
from codegen.elements.l2t2 import l2t2
from codegen.elements.string import string
from codegen.elements.thick import thick
from codegen.elements.thin import thin


def _table() -> dict[str, tuple[str, Callable[[], Element]]]:
    table: dict[str, tuple[str, Callable[[], Element]]] = {"l2t2": ("l2t2.py", l2t2)}
    for dim, where in ((2, "planar"), (3, "spatial")):
        table[f"string_{where}"] = ("string.py", partial(string, dim))
        table[f"string_{where}_slack"] = ("string.py", partial(string, dim, slack=True))
        for strain in ("green", "biot"):
            table[f"thin_{where}_{strain}"] = ("thin.py", partial(thin, dim, strain))
    for strain in ("green", "biot"):
        curved = partial(thin, 2, strain, curved=True)
        table[f"thin_planar_{strain}_curved"] = ("thin.py", curved)
    for dim, where in ((3, "thick"), (2, "thick_planar")):
        for curvature in ("axis", "section"):
            for section_strain in ("consistent", "nodal"):
                name, options = f"{where}_{curvature}_{section_strain}", (curvature, section_strain)
                table[name] = ("thick.py", partial(thick, dim, *options))
                table[f"{name}_curved"] = ("thick.py", partial(thick, dim, *options, curved=True))
    by_quadrature = partial(thick, 3, "axis", "consistent", by_quadrature=True)
    table["thick_axis_consistent_gauss"] = ("thick.py", by_quadrature)
    return {name: (f"codegen/elements/{file}", make) for name, (file, make) in table.items()}


ELEMENTS = _table()
"""Name of the module: the file that defines the element, and the function that builds it."""
