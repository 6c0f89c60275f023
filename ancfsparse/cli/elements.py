"""The command that builds an element of a user's own."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ancfsparse.kernels.building import build_element


def element(
    file: Annotated[
        Path, typer.Argument(help="Python file with ELEMENT = Element(...), its energy.")
    ],
    out: Annotated[Path, typer.Option(help="Folder in which to put the package.")] = Path(),
    instruction_set: Annotated[
        list[str] | None,
        typer.Option(help="x86_64, x86_64_v3 or x86_64_v4; repeated for several [this machine's]."),
    ] = None,
) -> None:
    """Build an element of your own from its energy: a package whose ELEMENT add_beam takes."""
    package = build_element(file, out, instruction_set or ())
    typer.echo(
        f"written: {package}\n"
        f"with {out.absolute()} in PYTHONPATH: from {package.name} import ELEMENT"
    )
