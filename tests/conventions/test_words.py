"""The text and the names of the repository use the terms of docs/architecture.md.

Each table lists what is left of a habit of writing; a limit may only be lowered.
"""

import ast
import re
from collections import Counter
from functools import cache

import pytest

import ancfsparse
from tests.paths import ROOT

SOURCES = ("ancfsparse", "codegen", "benchmarks", "tools")
PAGES = ("docs", "README.md", "CONTRIBUTING.md", "CHANGELOG.md")

# Patterns of prose, and how many are left in sources and pages together.
PROSE = {
    r"\bwhat (is|are|was|it|they|the|a|has|have|does|do) ": 16,  # a noun
    r'"""(What|How|Where|Whether|Why|Who)\b': 0,  # a verb or a noun first
    r"\bbeside\b": 3,  # next to, besides, compared with
    r"\basked for\b": 0,  # requested
    r", (of|to|from|in|by|at|with|for) (which|whose)\b": 62,
    r"\b(that|those) of (the|a|one|its|other)\b": 188,
    r"\bso (many|much|far|long)\b": 41,
    r"\b(is|are) to\b|\bmay be\b": 86,  # must, can
    r"\b(is|are) no\b": 70,  # is not
    r"\bnothing\b|\bnobody\b": 69,
    r"\bas (far|soon|long) as\b": 24,
    r"\btakes? (it|them|up|off|back)\b|\btaken for\b": 17,
    r"\bstands?\b": 13,
    r"\bperson\b|\bsomebody\b|\bthose who\b": 0,  # user
    r"\bmarch(ed|es|ing)\b": 0,  # integrate
    r"\bpilots?\b": 0,  # trial run
    r"\bby numbering\b": 8,  # eliminate coordinates: docs/theory.md alone explains it
    r"\b(said|told|meant|wish|wishes|hears?|lives|dies|died|anew|obeys?)\b": 0,
    r"\b(says?|means|tells?) (nothing|little)\b|\bknows? (no|nothing)\b": 0,
    r'"""(Say|Tell) ': 0,
}

# Words in names of classes, functions, arguments, variables and attributes, with the term for
# each, and in how many places (files times names) they are left.
NAMES = {
    "apart": ("difference", 4),
    "asked": ("tolerance", 0),
    "balance": ("equilibrium equations, residual", 1),
    "beside": ("compared with", 0),
    "course": ("prescribed motion", 7),
    "dearer": ("finer", 0),
    "entrant": ("candidate", 0),
    "fewest": ("min", 0),
    "fork": ("bifurcation", 3),
    "found": ("result", 33),
    "given": ("specified", 49),
    "hanging": ("free", 3),
    "haste": ("acceleration", 0),
    "held": ("constrained", 5),
    "judge": ("reference", 0),
    "kept": ("retained", 7),
    "least": ("min", 14),
    "led": ("prescribed", 0),
    "look": ("sample", 1),
    "looks": ("samples", 0),
    "made": ("built", 27),
    "march": ("integrate", 14),
    "marched": ("integrated", 0),
    "mine": ("this run", 8),
    "most": ("max", 6),
    "ours": ("this run", 11),
    "paced": ("resolved", 0),
    "pencil": ("linearized system", 0),
    "pilot": ("trial run", 0),
    "pilots": ("trial runs", 0),
    "place": ("index", 35),
    "places": ("indices", 61),
    "pull": ("tangent direction", 3),
    "push": ("load norm", 6),
    "rough": ("coarse", 2),
    "rung": ("element, level", 1),
    "seen": ("observed", 1),
    "sentence": ("message", 4),
    "settle": ("relax", 0),
    "settled": ("asymptotic", 2),
    "share": ("ratio, fraction", 14),
    "shares": ("ratios, fractions", 3),
    "shown": ("formatted", 2),
    "stuck": ("stagnated", 0),
    "sure": ("safety factor", 2),
    "theirs": ("other run", 0),
    "wanted": ("goal", 4),
    "way": ("method", 1),
    "ways": ("methods", 0),
    "whole": ("full", 2),
}

# Constants that are adjectives or verbs where a noun with a unit or a ratio is due.
ADJECTIVES = set(
    "MOST LEAST WORTH APART ENOUGH FAR NEAR ALIKE SMALL FEW FEWEST SAME CLOSE LOOKS FINER COARSE "
    "LARGE LONG SHORT SHARP STIFF SOFT SLOW FAST CHEAP DEAR ROUGH SURE HOPED BELIEVED LATE EARLY "
    "BESIDE BEYOND MANY MORE LESS MUCH LITTLE TINY HUGE TRUST PATIENCE FIRM LIMP RISE FALL".split()
)

ADJECTIVES_AS_CONSTANTS = 0
SEVERAL_CONSTANTS = 10  # lines that assign more than one
PARTICIPLES = 106  # functions named by one, where a verb and a noun are due
PREPOSITIONS = 120  # functions named by one
CLASSES_OF_ONE_NAME = 3


@cache
def texts():
    """Return the text of each source and page by its path."""
    files = [f for name in (*SOURCES, *PAGES) for f in ((ROOT / name).rglob("*"), [ROOT / name])]
    return {
        str(f.relative_to(ROOT)): f.read_text(encoding="utf-8")
        for group in files
        for f in group
        if f.suffix in {".py", ".pyx", ".pxi", ".h", ".md", ".sh"} and f.is_file()
    }


@cache
def trees():
    return {f: ast.parse(t) for f, t in texts().items() if f.endswith(".py")}


def prose(text):
    """Return a text in one line, without the marks of comments at line ends."""
    return re.sub(r"\s*\n\s*(?:(?:#:?|//|\*) )?", " ", text)


@cache
def lines_of_prose():
    return {file: prose(text) for file, text in texts().items()}


def hits(pattern):
    """Return each occurrence of a pattern, with its file and the words around it."""
    expression = re.compile(pattern, re.IGNORECASE if pattern.islower() else 0)
    return [
        f"{file}: ...{line[max(m.start() - 30, 0) : m.end() + 30]}..."
        for file, line in lines_of_prose().items()
        for m in expression.finditer(line)
    ]


@pytest.mark.parametrize("pattern", PROSE)
def test_prose_uses_the_words_of_numerical_analysis(pattern):
    found = hits(pattern)
    assert len(found) <= PROSE[pattern], "\n".join(found)


def test_patterns_find_what_they_are_for():
    text = prose("# Return what\n    # is beside it\n")
    assert re.search(next(iter(PROSE)), text)
    assert re.search(r"\bbeside\b", text)


def bound(tree):
    """Yield the names that a module defines, binds or assigns."""
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.arg(arg=name):
                yield name
            case ast.Name(id=name, ctx=ast.Store()) | ast.Attribute(attr=name, ctx=ast.Store()):
                yield name


@cache
def words_of_names():
    """Return the places, file and name, by the words of the names."""
    places = {}
    for file, tree in trees().items():
        for name in set(bound(tree)):
            for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name):
                places.setdefault(word.lower(), set()).add(f"{file}: {name}")
    return places


@pytest.mark.parametrize("word", NAMES)
def test_names_follow_the_glossary(word):
    term, limit = NAMES[word]
    found = sorted(words_of_names().get(word, ()))
    assert len(found) <= limit, f"{word} -> {term}\n" + "\n".join(found)


def constants(tree):
    """Yield the lists of names that lines of a module assign in capitals."""
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign):
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            parts = target.elts if isinstance(target, ast.Tuple) else [target]
            names = [part.id for part in parts if isinstance(part, ast.Name)]
            if names and all(re.fullmatch(r"_?[A-Z][A-Z0-9_]*", name) for name in names):
                yield names


def test_constants_are_nouns():
    found = [
        f"{file}: {name}"
        for file, tree in trees().items()
        for names in constants(tree)
        for name in names
        if name.strip("_") in ADJECTIVES
    ]
    assert len(found) <= ADJECTIVES_AS_CONSTANTS, "\n".join(found)


def test_a_line_assigns_one_constant():
    found = [
        f"{file}: {names}"
        for file, tree in trees().items()
        for names in constants(tree)
        if len(names) > 1
    ]
    assert len(found) <= SEVERAL_CONSTANTS, "\n".join(found)


PARTICIPLE = r"_?([a-z]{2,}ed|made|left|hung|found|held|kept|given|taken|chosen|shown)"
PREPOSITION = r"_?(of|at|on|by|in|off|with|beside|under|over|between|inside)(_[a-z_]+)?"


def functions(pattern):
    return [
        f"{file}:{node.lineno}: {node.name}"
        for file, tree in trees().items()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and re.fullmatch(pattern, node.name)
    ]


@pytest.mark.parametrize(
    ("pattern", "limit"), [(PARTICIPLE, PARTICIPLES), (PREPOSITION, PREPOSITIONS)]
)
def test_functions_are_named_by_verbs_and_nouns(pattern, limit):
    found = functions(pattern)
    assert len(found) <= limit, "\n".join(found)


def test_errors_and_warnings_are_named_so():
    public = {name: getattr(ancfsparse, name) for name in dir(ancfsparse)}
    classes = {name: c for name, c in public.items() if isinstance(c, type)}
    for name, one in classes.items():
        if issubclass(one, Warning):
            assert name.endswith("Warning")
        elif issubclass(one, Exception):
            assert name.endswith("Error")
        else:
            assert not name.endswith(("Error", "Warning"))


def test_no_two_classes_of_the_package_have_one_name():
    names = Counter(
        node.name
        for file, tree in trees().items()
        if file.startswith("ancfsparse/")
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
    )
    found = {name: n for name, n in names.items() if n > 1}
    assert len(found) <= CLASSES_OF_ONE_NAME, found
