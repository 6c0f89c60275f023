"""Factorizations of symmetric matrices on a fixed sparse pattern, exact and incomplete."""

from ancfsparse.seeds.deflated import DeflatedSeed
from ancfsparse.seeds.groups import Fill, Groups
from ancfsparse.seeds.incomplete import IncompleteSeed
from ancfsparse.seeds.modes import Slides
from ancfsparse.seeds.sparse import SparseSeed, fill_of

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
