"""Load amplitudes and generalized forces."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.system.loads.follower_loads import Follower, follower_at_node, follower_inside
    from ancfsparse.system.loads.time_dependent_eigenstrain import TimeDependentEigenstrain

__all__ = ["Follower", "TimeDependentEigenstrain", "follower_at_node", "follower_inside"]

__getattr__ = on_demand(
    __name__,
    {
        "follower_loads": "Follower follower_at_node follower_inside",
        "time_dependent_eigenstrain": "TimeDependentEigenstrain",
    },
)
