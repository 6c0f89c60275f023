"""Tables for terminals and pages."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

Item = TypeVar("Item")
Key = TypeVar("Key", bound=Hashable)


@dataclass(frozen=True)
class Table:
    """Cells of text under a head."""

    head: Sequence[str]  # names of the columns
    rows: Sequence[Sequence[str]]  # lines, of as many cells
    # numbers of the columns that are set to the left; all others are set to the right
    left: Sequence[int] = (0,)
    title: str = ""  # line above it on a terminal

    @classmethod
    def of(
        cls,
        items: Iterable[Item],
        columns: Mapping[str, Callable[[Item], str]],
        left: Sequence[int] = (0,),
        title: str = "",
    ) -> Table:
        """Set a line for each item; `columns` gives the cell under each head."""
        rows = [[cell(each) for cell in columns.values()] for each in items]
        return cls(list(columns), rows, left, title)

    def markdown(self) -> list[str]:
        """Return the lines for a page."""
        rule = ["---|" if column in self.left else "---:|" for column in range(len(self.head))]
        return [_line(self.head), "|" + "".join(rule), *map(_line, self.rows)]

    def __str__(self) -> str:
        """Set it for a terminal, in columns as wide as their cells."""
        cells = [self.head, *self.rows]
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        lines = [
            "  ".join(
                f"{cell:{'<' if column in self.left else '>'}{width}}"
                for column, (cell, width) in enumerate(zip(row, widths, strict=True))
            )
            for row in cells
        ]
        return "\n".join([self.title] * bool(self.title) + [f"  {each}".rstrip() for each in lines])


def _line(cells: Sequence[str]) -> str:
    return "".join(f"| {cell} " if cell else "| " for cell in cells) + "|"


def group_by(items: Iterable[Item], key: Callable[[Item], Key]) -> dict[Key, list[Item]]:
    """Group items by a key, in their order."""
    groups: dict[Key, list[Item]] = {}
    for item in items:
        groups.setdefault(key(item), []).append(item)
    return groups


def bullets(sentences: Iterable[str]) -> list[str]:
    """Return the lines of a list of sentences for a page."""
    return [f"- {each.removesuffix('.')}." for each in sentences]
