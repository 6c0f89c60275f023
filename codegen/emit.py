"""Print a derived element as a Cython module; the text depends only on the element."""

import hashlib
from collections.abc import Sequence

from codegen.declarations.fields import Element
from codegen.declarations.kernels import KERNELS
from codegen.derive import Program
from codegen.tape import PARAMETER, Node, Tape

LINE = 100
TIGHT, LOOSE = 2, 1
"""Precedence of a product (or anything in parentheses) and of a sum."""

PREAMBLE = '''\
# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""{title}."""

from cpython.pycapsule cimport PyCapsule_New
from libc.stdint cimport int32_t

import numpy as np

cdef extern from "kernel_abi.h":
    const char *ANCF_KERNEL_SIGNATURE

cdef extern from "simd.h" nogil:
    ctypedef double vec
    const int ANCF_LANES
    vec vec_gather(const double *values, const int32_t *places) noexcept
    vec vec_gather_next(
        const double *values, const int32_t *places, vec before, bint chained) noexcept
    vec vec_parameter(const double *set, int number) noexcept
    vec vec_reciprocal(vec v) noexcept
    vec vec_set1(double x) noexcept
    vec vec_sqrt(vec v) noexcept
    void vec_scatter_add(double *out, const int32_t *places, vec v) noexcept
    void vec_scatter_add_nodes(
        double *out, const int32_t *first, const int32_t *second, vec u, vec v,
        bint chained) noexcept

SIGNATURE = ANCF_KERNEL_SIGNATURE.decode("ascii")
NAME = "{name}"
DEFINITION = "{definition}"
DIM = {dim}
LANES = ANCF_LANES
N_NODES = 2
NODE_COORDINATES = {node_coordinates}
SECTION = {section}
PARAMETERS = {parameters}
OWN_PARAMETERS = {own}
N_DERIVED = {n_derived}
SIZES = {sizes}
OPERATIONS = {operations}
'''

SIGNATURE = """\
cdef void {name}(
    ptrdiff_t n_blocks, const int32_t *gather, const int32_t *scatter, const int32_t *set_of,
    const double *parameters, const double *q, const double *a, double *out,
) noexcept nogil:
    cdef ptrdiff_t b
    cdef const double *p
    cdef bint chained
"""


class Printer:
    """Prints nodes as expressions; short ones that are used only once are inlined."""

    def __init__(self, tape: Tape, outputs: Sequence[Node]) -> None:
        self.tape = tape
        self.uses: dict[Node, int] = {}
        for node in tape.reachable(outputs):
            for operand in tape[node].args:
                self.uses[operand] = self.uses.get(operand, 0) + 1
        for node in outputs:
            self.uses[node] = self.uses.get(node, 0) + 1
        self.text: dict[Node, tuple[str, int]] = {}
        self.lines: list[str] = []
        self.names: list[str] = []

    def order(self, outputs: Sequence[Node]) -> list[Node]:
        """Order with the operands of each output just before it, for short lifetimes of values."""
        done: set[Node] = set()
        result: list[Node] = []
        for output in outputs:
            stack = [(output, False)]
            while stack:
                node, ready = stack.pop()
                if node in done:
                    continue
                if ready:
                    done.add(node)
                    result.append(node)
                else:
                    stack.append((node, True))
                    stack.extend((a, False) for a in reversed(self.tape[node].args))
        return result

    def leaf(self, node: Node) -> str | None:
        """Text of a node that needs no operation."""
        raise NotImplementedError

    def expression(self, node: Node) -> tuple[str, int]:
        """Text of a node in terms of its operands, and its precedence."""
        entry = self.tape[node]
        args = [self.text[a] for a in entry.args]
        closed = [text if binding == TIGHT else f"({text})" for text, binding in args]
        if entry.op == "add":
            return f"{args[0][0]} + {args[1][0]}", LOOSE
        if entry.op == "sub":
            return f"{args[0][0]} - {closed[1]}", LOOSE
        if entry.op == "mul":
            return f"{closed[0]} * {closed[1]}", TIGHT
        if entry.op == "neg":
            return f"-{closed[0]}", LOOSE
        return self.function(entry.op, args[0][0]), TIGHT

    def function(self, op: str, argument: str) -> str:
        """Text of a function call."""
        raise NotImplementedError

    def visit(self, node: Node) -> None:
        """Set the text of a node, on a separate line if it is long or used more than once."""
        if node in self.text:
            return
        leaf = self.leaf(node)
        if leaf is not None:
            self.text[node] = (leaf, TIGHT)
            return
        text, binding = self.expression(node)
        if self.uses[node] > 1 or len(text) > LINE - 40:
            name = f"t{len(self.names)}"
            self.names.append(name)
            self.lines.append(f"{name} = {text}")
            text, binding = name, TIGHT
        self.text[node] = (text, binding)


class KernelPrinter(Printer):
    """Arithmetic on vectors inside the loop over blocks."""

    def __init__(self, program: Program, outputs: Sequence[Node]) -> None:
        super().__init__(program.tape, outputs)
        self.derived = {node: k for k, node in enumerate(program.derived)}
        self.half = program.element.n_coordinates // 2
        self.inputs: list[str] = []

    def leaf(self, node: Node) -> str | None:
        """Text of a constant or an input."""
        entry = self.tape[node]
        if entry.op == "const":
            return repr(float(entry.value))
        if node in self.derived:
            return f"vec_parameter(p, {self.derived[node]})"
        if entry.op in ("coordinate", "acceleration"):
            source = {"coordinate": "q", "acceleration": "a"}[entry.op]
            return self.gathered(source, int(entry.value))
        return None

    def gathered(self, source: str, number: int) -> str:
        """Name of a gathered coordinate; those of the second node follow that of the first."""
        name = f"{source}{number}"
        if name not in self.inputs:
            where = f"gather + {number} * ANCF_LANES"
            call = f"vec_gather({source}, {where})"
            if number >= self.half:
                twin = self.gathered(source, number - self.half)
                call = f"vec_gather_next({source}, {where}, {twin}, chained)"
            self.inputs.append(name)
            self.lines.append(f"{name} = {call}")
        return name

    def function(self, op: str, argument: str) -> str:
        """Text of a call into `simd.h`."""
        return f"vec_{op}({argument})"


class PreparePrinter(Printer):
    """Arithmetic on parameters, as NumPy columns."""

    def leaf(self, node: Node) -> str | None:
        """Text of a constant or an input."""
        entry = self.tape[node]
        if entry.op == "const":
            return repr(float(entry.value))
        return str(entry.value) if entry.op == "parameter" else None

    def function(self, op: str, argument: str) -> str:
        """Text of a NumPy call."""
        return f"np.sqrt({argument})" if op == "sqrt" else f"(1.0 / ({argument}))"


def wrapped(prefix: str, names: Sequence[str], indent: str) -> list[str]:
    """Write a declaration of many names in lines of limited length."""
    lines: list[str] = []
    current = ""
    for name in names:
        if current and len(indent + prefix + current + name) > LINE - 2:
            lines.append(indent + prefix + current.rstrip(", "))
            current = ""
        current += name + ", "
    return [*lines, indent + prefix + current.rstrip(", ")] if current else lines


def kernel(program: Program, name: str) -> str:
    """Print one kernel as a Cython function."""
    tape, outputs = program.tape, program.outputs[name]
    printer = KernelPrinter(program, outputs)
    lines = [SIGNATURE.format(name=name).rstrip("\n")]
    body = [
        "chained = set_of[b] < 0",
        "p = parameters + <ptrdiff_t>(~set_of[b] if chained else set_of[b])"
        f" * {len(program.derived)} * ANCF_LANES",
    ]
    n = program.element.n_coordinates
    by_node = len(outputs) == n
    for number in sorted(range(len(outputs)), key=lambda k: (k % (n // 2), k) if by_node else k):
        output = outputs[number]
        if tape.constant_value(output) == 0 and not by_node:
            continue
        for node in printer.order([output]):
            if tape.level[node] != PARAMETER or node in printer.derived:
                printer.visit(node)
        body += printer.lines
        printer.lines = []
        text, places = printer.text[output][0], f"scatter + {number} * ANCF_LANES"
        if tape.constant_value(output) is not None:
            text = f"vec_set1({text})"
        if not by_node:
            body.append(f"vec_scatter_add(out, {places}, {text})")
        elif number < n // 2:
            first = f"out, {places}, scatter + {number + n // 2} * ANCF_LANES, {text}"
        else:
            body.append(f"vec_scatter_add_nodes({first}, {text}, chained)")
    body.append(f"gather += {program.element.n_coordinates} * ANCF_LANES")
    body.append(f"scatter += {len(outputs)} * ANCF_LANES")
    lines += wrapped("cdef vec ", printer.inputs + printer.names, "    ")
    lines.append("    for b in range(n_blocks):")
    return "\n".join(lines + ["        " + line for line in body])


def prepare(program: Program) -> str:
    """Print the function that turns base parameters into derived ones."""
    printer = PreparePrinter(program.tape, program.derived)
    for node in printer.order(program.derived):
        printer.visit(node)
    names = ", ".join(program.parameters)
    lines = [
        "def prepare(base):",
        '    """Derived parameters (n, N_DERIVED) from base parameters (n, len(PARAMETERS))."""',
        f"    {names} = np.asarray(base, dtype=np.float64).T",
        *("    " + line for line in printer.lines),
        "    return np.stack([",
        *(f"        {printer.text[node][0]}," for node in program.derived),
        "    ], axis=-1)",
    ]
    return "\n".join(lines)


def definition(element: Element) -> str:
    """Return a digest of the element's definition, whatever its file and this generator."""
    e = element
    parts: tuple[object, ...]
    parts = e.dim, e.node, e.section, e.fields, e.strains, e.projected, e.energy, e.inertia, e.own
    if e.curved:
        parts += ("curved",)
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def module(program: Program, header: str) -> str:
    """Print a whole generated module."""
    element = program.element
    n = element.n_coordinates
    preamble = PREAMBLE.format(
        title=element.title,
        name=element.name,
        definition=definition(element),
        dim=element.dim,
        node_coordinates=element.node_coordinates,
        section=element.section,
        parameters=tuple(program.parameters),
        own={each.name: each.group for each in element.own if each.name in program.parameters},
        n_derived=len(program.derived),
        sizes={k.name: k.size(n) for k in KERNELS if k.name in program.outputs},
        operations=program.operations(),
    )
    kernels = "\n\n\n".join(kernel(program, name) for name in program.outputs)
    table = "\n".join(
        f'    "{name}": PyCapsule_New(<void *>{name}, ANCF_KERNEL_SIGNATURE, NULL),'
        for name in program.outputs
    )
    return (
        f"{header}{preamble}\n\n{prepare(program)}\n\n\n{kernels}\n\n\nkernels = {{\n{table}\n}}\n"
    )
