"""The constraints that `make test-oldest` gives to pip."""

import pytest

from tools import lower_bounds as tool

PROJECT = """
[build-system]
requires = ["ninja", "cython>=3.2,<4"]
[project]
dependencies = ["numpy>=2.0", "scikit-sparse>=0.4.16,<0.5"]
[project.optional-dependencies]
sweep = ["dask[distributed]>=2024.8", "{again}"]
dev = ["ruff>=0.17", "project[sweep]", "sympy==1.14.0"]
"""


def test_every_lower_bound_is_taken_once():
    found = tool.lower_bounds(PROJECT.format(again="numpy>=2.0"))
    packages = ["cython==3.2", "dask==2024.8", "numpy==2.0", "ruff==0.17", "scikit-sparse==0.4.16"]
    assert found == packages


def test_bounds_that_contradict_each_other_are_named():
    with pytest.raises(ValueError, match=r"numpy has two lower bounds, 2\.0 and 2\.1"):
        tool.lower_bounds(PROJECT.format(again="numpy>=2.1"))


def test_the_dependencies_of_this_package_have_lower_bounds():
    names = {each.split("==")[0] for each in tool.lower_bounds(tool.PROJECT.read_text())}
    assert {"numpy", "scipy", "cython", "h5py", "matplotlib", "typer", "tqdm"} <= names
