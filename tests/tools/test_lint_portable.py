"""What the lint of portability finds, and what it leaves alone."""

import pytest

from tools import lint_portable as lint

OFF = "# cython: language_level=3, wraparound=False\n"


@pytest.mark.parametrize(
    "line",
    [
        "n = start[-1]",
        "n = start[ -n]",
        "root = first[parts[-2]]",
        'n = a["start"][-1]',
        "n = rows(x)[-1]",
        "n = matrix[0, -1]",
        "n = matrix[-1, 2:]",
        "n = matrix[\n    -1]",
    ],
)
def test_a_negative_index_is_found_where_wraparound_is_off(line):
    (number,) = lint.negative_indices(OFF + "cdef f(x):\n    " + line + "\n")
    assert number == 3 + line.count("\n")
    assert list(lint.negative_indices(line, is_included=True)) == [1 + line.count("\n")]
    assert not list(lint.negative_indices("# cython: language_level=3\n" + line))


@pytest.mark.parametrize(
    "line",
    [
        "below = rows[:-1]",
        "below = rows[-3:]",
        "below = rows[1:-1, 0]",
        "signs = [-1, 1]",
        "signs = f([-1, 1], -2)",
        "for sign in [-1, 1]:",
        "n = start[n - 1]",
        "n = start[f(-1)]",
        '"""start[-1]"""',
        "n = 1  # start[-1]",
        "n = values[-1]  # before the pointer",
    ],
)
def test_slices_lists_text_and_lines_that_give_their_reason_are_left_alone(line):
    assert not list(lint.negative_indices(OFF + line + "\n"))


@pytest.mark.parametrize(
    "line",
    [
        "pip install --no-build-isolation -Csetup-args=-Dx=all -e .",
        "pip install -C setup-args=-Dx=all .",
        "python -m pip install \\\n  --group dev",
        "python3 -m venv --without-scm-ignore-files .venv",
    ],
)
def test_an_option_that_the_tools_of_debian_12_lack_is_found(line):
    ((number, reason),) = lint.newer_options("set -e\n" + line + "\n")
    assert number == 2
    assert "Debian 12 has" in reason


@pytest.mark.parametrize(
    "line",
    [
        "pip install --config-settings=setup-args=-Dx=all -e .",
        "# pip knows -C from 23.1 on",
        "pip install . && ninja -C build",
        "make -C folder",
    ],
)
def test_other_options_are_left_alone(line):
    assert not list(lint.newer_options(line + "\n"))


def test_this_repository_has_none(capsys):
    assert lint.main() == 0, capsys.readouterr().out
