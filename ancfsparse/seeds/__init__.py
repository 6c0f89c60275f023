"""Seeds: complete and incomplete factorizations of symmetric matrices on a fixed pattern."""

from typing import TYPE_CHECKING, TypeAlias

from ancfsparse.on_demand import on_demand
from ancfsparse.seeds.complete.sparse_seed import SparseSeed as SparseSeed, fill_of as fill_of

if TYPE_CHECKING:
    from ancfsparse.seeds.coupled.coupled_seed import CoupledSeed as CoupledSeed
    from ancfsparse.seeds.incomplete.deflated_gradients import DeflatedSeed as DeflatedSeed
    from ancfsparse.seeds.incomplete.incomplete_seed import IncompleteSeed as IncompleteSeed
    from ancfsparse.seeds.incomplete.sliding_modes import Slides as Slides
    from ancfsparse.seeds.ordering.unknown_groups import Fill as Fill, Groups as Groups

    Seed: TypeAlias = SparseSeed | IncompleteSeed

__getattr__ = on_demand(
    __name__,
    {
        "coupled.coupled_seed": "CoupledSeed",
        "incomplete.deflated_gradients": "DeflatedSeed",
        "incomplete.incomplete_seed": "IncompleteSeed",
        "incomplete.sliding_modes": "Slides",
        "ordering.unknown_groups": "Fill Groups",
    },
)
