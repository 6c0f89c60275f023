"""Sparsity pattern, compiled assembly, division among threads."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.system.assembly.thread_partition import partition_blocks, partition_elements

__all__ = ["partition_blocks", "partition_elements"]

__getattr__ = on_demand(__name__, {"thread_partition": "partition_blocks partition_elements"})
