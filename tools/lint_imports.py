"""Run import-linter on the source tree.

import-linter asks Python where the package is, and the loader of an editable install answers with a
place that holds no files. Without that loader Python finds the source tree itself.
"""

import sys

from importlinter.cli import lint_imports_command

sys.path.insert(0, ".")
sys.meta_path[:] = [f for f in sys.meta_path if "editable" not in type(f).__module__]
lint_imports_command()
