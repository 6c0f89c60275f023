"""The command ``ancfsparse``; its computations are loaded when it runs."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.cli.app import main
    from ancfsparse.cli.planned import ELEMENTS, ERROR, compare_with_paper, plan_scene
    from ancfsparse.cli.problem import list_problems, run_problem

__all__ = [
    "ELEMENTS",
    "ERROR",
    "compare_with_paper",
    "list_problems",
    "main",
    "plan_scene",
    "run_problem",
]

__getattr__ = on_demand(
    __name__,
    {
        "app": "main",
        "planned": "ELEMENTS ERROR compare_with_paper plan_scene",
        "problem": "list_problems run_problem",
    },
)
