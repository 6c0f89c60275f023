"""In comes a symmetric matrix on a fixed sparse pattern, out goes its inverse as a solve."""

from ancfsparse.seeds.sparse import SparseSeed, fill_of

__all__ = ["SparseSeed", "fill_of"]
