"""Refuse to test compiled modules that are older than their sources."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def pytest_sessionstart():
    if Path(sys.prefix) == ROOT / ".venv":
        command = [ROOT / "tools/setup.sh", "check"]
        check = subprocess.run(command, capture_output=True, text=True)
        if check.returncode:
            pytest.exit(check.stderr.strip(), returncode=pytest.ExitCode.USAGE_ERROR)
