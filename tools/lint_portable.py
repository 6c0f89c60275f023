"""Find what runs on this machine and fails on another.

Two rules.  Cython passes a negative index on as it is where ``wraparound`` is off, and only some
versions of NumPy take it for one from the end; a line that means an address before a pointer says
``# before the pointer``.  And set-up may use no option that the tools of Debian 12 do not have yet.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
REASON = "# before the pointer"

NEWER_OPTIONS = [  # tool, option, first version that has it, version in Debian 12
    ("pip", "-C", "23.1", "23.0.1"),
    ("pip", "--keyring-provider", "23.1", "23.0.1"),
    ("pip", "--group", "25.1", "23.0.1"),
    ("venv", "--without-scm-ignore-files", "3.13", "3.11.2"),
    ("make", "--shuffle", "4.4", "4.3"),
    ("cp", "--update=none", "9.3", "9.1"),
    ("git clone", "--revision", "2.49", "2.39"),
]
SCRIPTS = ["Makefile", ".ci/*", "*.sh", "*.yml", "*.md"]

_LITERAL = re.compile(r'"""(?:.|\n)*?"""|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'')
_COMMENT = re.compile(r"#.*")
_WRAPAROUND_OFF = re.compile(r"^# *cython:.*\bwraparound *= *False", re.MULTILINE)


def negative_indices(source: str, is_included: bool = False) -> Iterator[int]:
    """Find lines with a negative index in a Cython source.

    Parameters
    ----------
    source : str
        Text of the file.
    is_included : bool
        Whether it is included by others, so that their directives hold.

    Yields
    ------
    int
        Number of the line, from 1.
    """
    if not is_included and not _WRAPAROUND_OFF.search(source):
        return
    lines = source.splitlines()
    code = _LITERAL.sub(lambda found: '""' + "\n" * found[0].count("\n"), source)
    code = _COMMENT.sub("", code)
    open_brackets: list[str] = []  # "index" or the bracket
    begins = False  # whether an index begins here
    number = 1
    before = ""
    for match in re.finditer(r"\s+|\w+|.", code):
        token = match[0]
        if token.isspace():
            number += token.count("\n")
            continue
        if begins and token == "-" and not _is_slice(code[match.end() :]):
            if REASON not in lines[number - 1]:
                yield number
        begins = False
        if token in "([{":
            is_index = token == "[" and bool(re.fullmatch(r"\w+|[)\]]|\"", before))
            is_index = is_index and before not in {"return", "in", "and", "or", "not", "if", "else"}
            open_brackets.append("index" if is_index else token)
            begins = is_index
        elif token in ")]}" and open_brackets:
            open_brackets.pop()
        elif token == ",":
            begins = bool(open_brackets) and open_brackets[-1] == "index"
        before = token


def _is_slice(rest: str) -> bool:
    """Return whether a colon comes before the index ends."""
    depth = 0
    for letter in rest:
        if letter in "([{":
            depth += 1
        elif letter in ")]}":
            if depth == 0:
                return False
            depth -= 1
        elif depth == 0 and letter in ",:":
            return letter == ":"
    return False


def newer_options(source: str) -> Iterator[tuple[int, str]]:
    """Find lines of a script with options that the tools of Debian 12 do not have.

    Parameters
    ----------
    source : str
        Text of the script or page.

    Yields
    ------
    line, reason : int, str
        Number of the line, from 1, on which the command begins; the fault.
    """
    source = re.sub(r"(^|\s)#.*", r"\1", source)
    number = 1
    for command in re.split(r"(?<!\\)\n", source):
        for tool, option, version, present in NEWER_OPTIONS:
            name = re.escape(option)
            if len(option) == 2:  # a letter, whose value may follow at once
                name += r"(?![-])"
            else:
                name += r"(?![-\w])"
            if re.search(rf"\b{tool}\b[^;|&`]*\s{name}", command):
                yield number, f"{option} needs {tool} {version}; Debian 12 has {present}"
        number += command.count("\n") + 1


def _tracked(*patterns: str) -> list[Path]:
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *patterns]
    names = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return [ROOT / name for name in names.splitlines() if (ROOT / name).is_file()]


def main() -> int:
    """Print the findings; return 1 if there is anything, else 0."""
    found = []
    for file in _tracked("*.pyx", "*.pxi"):
        for number in negative_indices(file.read_text(encoding="utf-8"), file.suffix == ".pxi"):
            reason = f"negative index with wraparound off; count from 0, or say {REASON!r}"
            found.append(f"{file.relative_to(ROOT)}:{number}: {reason}")
    for file in _tracked(*SCRIPTS):
        for number, reason in newer_options(file.read_text(encoding="utf-8")):
            found.append(f"{file.relative_to(ROOT)}:{number}: {reason}")
    print("\n".join(found) if found else "All runs elsewhere too, as far as this lint can see.")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
