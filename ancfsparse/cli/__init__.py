"""The command ``ancfsparse``; its computations are loaded when it runs."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.cli.app import main as main
    from ancfsparse.cli.planned import (
        ELEMENTS as ELEMENTS,
        ERROR as ERROR,
        compare_with_paper as compare_with_paper,
        plan_scene as plan_scene,
    )
    from ancfsparse.cli.problem import list_problems as list_problems, run_problem as run_problem

__getattr__ = on_demand(
    __name__,
    {
        "app": "main",
        "planned": "ELEMENTS ERROR compare_with_paper plan_scene",
        "problem": "list_problems run_problem",
    },
)
