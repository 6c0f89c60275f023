"""Seeds: complete and incomplete factorizations of symmetric matrices on a fixed pattern."""

from ancfsparse.seeds.complete.sparse_seed import SparseSeed, fill_of
from ancfsparse.seeds.incomplete.deflated_gradients import DeflatedSeed
from ancfsparse.seeds.incomplete.incomplete_seed import IncompleteSeed
from ancfsparse.seeds.incomplete.sliding_modes import Slides
from ancfsparse.seeds.ordering.unknown_groups import Fill, Groups

Seed = SparseSeed | IncompleteSeed

__all__ = [
    "DeflatedSeed",
    "Fill",
    "Groups",
    "IncompleteSeed",
    "Seed",
    "Slides",
    "SparseSeed",
    "fill_of",
]
