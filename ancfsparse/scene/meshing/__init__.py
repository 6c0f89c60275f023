"""Construction of checked beams and meshes from arguments."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.meshing.curved_beam import build_curved_beam
    from ancfsparse.scene.meshing.eigenstrain import with_eigenstrain
    from ancfsparse.scene.meshing.mesh_lines import build_mesh
    from ancfsparse.scene.meshing.node_edge_checks import check_graph
    from ancfsparse.scene.meshing.offset_beam import offset_from_line

__all__ = ["build_curved_beam", "build_mesh", "check_graph", "offset_from_line", "with_eigenstrain"]

__getattr__ = on_demand(
    __name__,
    {
        "curved_beam": "build_curved_beam",
        "eigenstrain": "with_eigenstrain",
        "mesh_lines": "build_mesh",
        "node_edge_checks": "check_graph",
        "offset_beam": "offset_from_line",
    },
)
