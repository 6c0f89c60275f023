"""Temporary."""
from dataclasses import dataclass
from types import ModuleType
from ancfsparse.kernels.dispatch import compiled
@dataclass(frozen=True)
class ElementKind:
    module: ModuleType
    @property
    def n_nodal(self): return len(self.module.NODE_COORDINATES)
    @property
    def node_coordinates(self): return self.module.NODE_COORDINATES
    @property
    def parameters(self): return self.module.PARAMETERS
    @property
    def operations(self): return self.module.OPERATIONS
    @property
    def kernels(self): return self.module.kernels
def element_kind(element, dim, **o):
    name = {"l2t2":"l2t2","thin":f"thin_{'planar' if dim==2 else 'spatial'}_{o.get('strain')}","thick":f"thick_{'planar_' if dim==2 else ''}{o.get('curvature')}_{o.get('section_strain')}"}[element]
    return ElementKind(compiled(name))
