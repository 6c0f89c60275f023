"""The command ``ancfsparse element``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ancfsparse.kernels.building import build_element


def element(
    file: Annotated[
        Path,
        typer.Argument(help="Python file with ELEMENT = Element(...), which declares the energy."),
    ],
    out: Annotated[Path, typer.Option(help="Folder of the package.")] = Path(),
    instruction_set: Annotated[
        list[str] | None,
        typer.Option(
            help="x86_64, x86_64_v3 or x86_64_v4; may be repeated [default: of this processor]."
        ),
    ] = None,
) -> None:
    """Build a user element from its energy: a package with an ELEMENT for add_beam."""
    package = build_element(file, out, instruction_set or ())
    typer.echo(
        f"written: {package}\n"
        f"with {out.absolute()} in PYTHONPATH: from {package.name} import ELEMENT"
    )
