"""Time kernels: nanoseconds of processor time per element, with data in cache.

Gather and scatter are included.  Full vectors are compared with one lane by compiling the same
generated file once more with ``ANCF_LANES=1``, which needs a checkout.
"""

import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import available_instruction_sets, compiled_module, instruction_set
from ancfsparse.errors import InputError
from ancfsparse.kernels.building import ARCHITECTURE_FLAGS, compile_c, translate
from ancfsparse.kernels.catalog import REFERENCES, module_names
from ancfsparse.kernels.element_kind import ElementKind, from_module
from ancfsparse.kernels.layout import pack

GENERATED = Path(__file__).resolve().parents[2] / "generated"


@dataclass(frozen=True)
class Timing:
    """One kernel on one instruction set."""

    name: str
    kernel: str
    instruction_set: str
    lanes: int
    operations: int
    ns_per_element: float


def time_kernel(
    kind: ElementKind, kernel: str, *, n_elements: int = 128, seconds: float = 0.02, rounds: int = 7
) -> float:
    """Return the best time per element [ns] of a kernel on a chain of equal elements.

    Parameters
    ----------
    kind : ElementKind
        Element to time.
    kernel : str
        One of its kernels.
    n_elements : int
        Length of the chain; 128 elements stay in cache.
    seconds, rounds : float, int
        Length of one measurement and how many are made.
    """
    h, n, n_out = len(kind.node_coordinates), kind.n_coordinates, kind.n_out(kernel)
    places = np.arange(n_elements)[:, None] * h + np.arange(n)
    rows = np.arange(n_elements)[:, None] * n_out + np.arange(n_out)
    scatter = places if n_out == n else rows
    layout = pack(kind, places, scatter, np.ones((n_elements, len(kind.parameters))))
    q = _chain(kind, n_elements)
    out = np.zeros(int(scatter.max()) + 1)
    call = compiled_module("kernel_call").call
    arrays = (layout.gather, layout.scatter, layout.set_of, layout.parameters, q, q, out)

    def run(repeat: int) -> float:
        out[:] = 0.0
        start = time.process_time()
        call(kind.kernels[kernel], *arrays, repeat)
        return time.process_time() - start

    repeat = max(1, int(seconds / max(run(1), 1e-7)))
    return min(run(repeat) for _ in range(rounds)) / (repeat * n_elements) * 1e9


def _chain(kind: ElementKind, n_elements: int) -> NDArray[np.float64]:
    """Coordinates of a slightly wavy chain of elements of length 1."""
    axis = {"r_x": 0, "r_y": 1, "r_z": 2}
    straight = [
        float(axis.get(label[:-1], -1) == int(label[-1]) - 1) for label in kind.node_coordinates
    ]
    nodes = np.tile(straight, (n_elements + 1, 1))
    nodes[:, 0] = np.arange(n_elements + 1)
    wave = 0.01 * np.random.default_rng(0).normal(size=nodes.shape)
    return np.asarray(nodes + wave).ravel()


def kernel_table(
    names: Sequence[str] | None = None, instruction_sets: Sequence[str] | None = None
) -> list[Timing]:
    """Time every kernel of the named modules (default: all) on the named instruction sets."""
    table = []
    for name in names or (*module_names(), *REFERENCES):
        for set_name in instruction_sets or available_instruction_sets():
            table += _timings(from_module(compiled_module(name, set_name)), set_name)
    return table


def _timings(kind: ElementKind, set_name: str) -> list[Timing]:
    return [
        Timing(
            kind.name,
            kernel,
            set_name,
            kind.lanes,
            kind.operations[kernel],
            time_kernel(kind, kernel),
        )
        for kernel in kind.kernels
    ]


def one_lane(name: str, folder: Path) -> ElementKind:
    """Compile a generated module with one lane and otherwise as for the instruction set in use."""
    source, library = folder / f"{name}.pyx", folder / f"{name}.so"
    if not (GENERATED / source.name).exists():
        raise InputError(
            f"Comparing with one lane needs a checkout: {GENERATED / source.name} does not exist."
        )
    module_name = f"ancfsparse.compiled.{name}"
    source.write_bytes((GENERATED / source.name).read_bytes())
    compile_c(
        translate(source, module_name),
        library,
        ARCHITECTURE_FLAGS[instruction_set()],
        "-DANCF_LANES=1",
    )
    loader = ExtensionFileLoader(module_name, str(library))
    spec = spec_from_loader(module_name, loader)
    if spec is None:
        raise ImportError(f"{library} cannot be imported.")
    module = module_from_spec(spec)
    loader.exec_module(module)
    return from_module(module)


def speed_ratios(names: Sequence[str], kernel: str = "force") -> dict[str, tuple[float, float]]:
    """Time per element [ns] of a kernel with one lane and with full vectors, by module."""
    result = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            single = time_kernel(one_lane(name, Path(folder)), kernel)
            result[name] = (single, time_kernel(from_module(compiled_module(name)), kernel))
    return result
