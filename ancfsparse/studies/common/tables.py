"""Tables of pages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def table(
    head: Sequence[str], rows: Iterable[Sequence[str]], left: Sequence[int] = (0,)
) -> list[str]:
    """Return the lines of a table; columns are set to the right but for those of these numbers."""
    rule = ["---|" if column in left else "---:|" for column in range(len(head))]
    return [_line(head), "|" + "".join(rule), *map(_line, rows)]


def _line(cells: Sequence[str]) -> str:
    return "".join(f"| {cell} " if cell else "| " for cell in cells) + "|"


def with_findings(lines: Iterable[str], findings: Iterable[str]) -> str:
    """Put a list of sentences below the lines of a page."""
    return "\n".join([*lines, "", *(f"- {each}" for each in findings)])
