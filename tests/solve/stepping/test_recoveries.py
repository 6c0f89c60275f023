"""The page on stability lists the attempts at a failed step as the code does."""

from pathlib import Path

from ancfsparse.nonlinear import Attempt
from ancfsparse.solve import recovery
from ancfsparse.solve.recovery.recovery import RECOVERIES

PAGE = Path(__file__).parents[3] / "docs" / "stability.md"


def test_the_page_lists_the_recoveries_in_their_order():
    rows = [(each.description, each.summary) for each in Attempt if each != Attempt.METHOD]
    for name in RECOVERIES:
        kind = getattr(recovery, name)
        rows.append((kind.name, kind.__doc__.partition("\n")[0]))
    table = "".join(f"| {name} | {summary} |\n" for name, summary in rows)
    assert f"|---|---|\n{table}\n" in PAGE.read_text()
