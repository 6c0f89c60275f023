"""The inputs that loads, lengths and prescribed motions of a system follow."""

from __future__ import annotations

from ancfsparse.errors import InputError
from ancfsparse.scene import Input
from ancfsparse.system.system import System
from ancfsparse.system.used_signals import signals_of


def inputs_of(system: System) -> dict[str, Input]:
    """Return the inputs of a system by their names.

    Raises
    ------
    InputError
        If two inputs of one name differ.
    """
    inputs: dict[str, Input] = {}
    for each in (used.signal for used in signals_of(system)):
        if isinstance(each, Input) and inputs.setdefault(each.name, each) != each:
            raise InputError(
                f"inputs of one name are one input, but {inputs[each.name]!r} and {each!r} differ: "
                "give one of them another name"
            )
    return inputs
