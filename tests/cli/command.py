"""The command as tests call it."""

import pytest

from ancfsparse.cli import main


def run(capsys, *words):
    """Return the exit code of the command with these words, and what it wrote: output, errors."""
    with pytest.raises(SystemExit) as left:
        main([str(word) for word in words])
    out, err = capsys.readouterr()
    return left.value.code, out, err
