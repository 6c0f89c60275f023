"""The command ``ancfsparse``."""

from ancfsparse.cli.app import main

__all__ = ["main"]
