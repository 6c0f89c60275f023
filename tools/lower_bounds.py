"""Print the oldest versions that pyproject.toml allows, one constraint of pip a line."""

import re
import tomllib
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent / "pyproject.toml"
BOUND = re.compile(r"([\w-]+)(?:\[[\w,-]+\])?>=([\d.]+)")


def lower_bounds(text: str) -> list[str]:
    """Return ``name==version`` for every requirement with a lower bound, sorted, each once.

    Raises
    ------
    ValueError
        If a package has two lower bounds.
    """
    table = tomllib.loads(text)
    project = table["project"]
    requirements = [*table["build-system"]["requires"], *project["dependencies"]]
    for extra in project["optional-dependencies"].values():
        requirements += extra
    bounds: dict[str, str] = {}
    for requirement in requirements:
        if found := BOUND.match(requirement):
            name, version = found.groups()
            if bounds.setdefault(name, version) != version:
                raise ValueError(f"{name} has two lower bounds, {bounds[name]} and {version}")
    return [f"{name}=={version}" for name, version in sorted(bounds.items())]


if __name__ == "__main__":
    print("\n".join(lower_bounds(PROJECT.read_text(encoding="utf-8"))))
