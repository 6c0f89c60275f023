"""The command ``ancfsparse``; what a command computes is loaded when it runs."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.cli.app import main
    from ancfsparse.cli.planned import ELEMENTS, ERROR, contest, plan_scene
    from ancfsparse.cli.problem import listing, run_problem

__all__ = ["ELEMENTS", "ERROR", "contest", "listing", "main", "plan_scene", "run_problem"]

__getattr__ = on_demand(
    __name__,
    {
        "ELEMENTS": "planned",
        "ERROR": "planned",
        "contest": "planned",
        "listing": "problem",
        "main": "app",
        "plan_scene": "planned",
        "run_problem": "problem",
    },
)
