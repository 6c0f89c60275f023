"""The inputs that loads, lengths and prescribed motions of a system follow."""

from __future__ import annotations

from ancfsparse.errors import InputError
from ancfsparse.scene import Input, Signal
from ancfsparse.scene.force_elements.ropes import Rope
from ancfsparse.system.system import System
from ancfsparse.system.used_signals import signals_of


def inputs_of(system: System) -> dict[str, Input]:
    """Return the inputs of a system by their names.

    Raises
    ------
    InputError
        If two inputs of one name differ.
    """
    lengths = [each.given for each in system.attachments if isinstance(each, Rope)]
    signals = [each.signal for each in signals_of(system)]
    signals += [part for each in lengths if isinstance(each, Signal) for part in each.summands]
    inputs: dict[str, Input] = {}
    for each in signals:
        if isinstance(each, Input) and inputs.setdefault(each.name, each) != each:
            raise InputError(
                f"inputs of one name are one input, but {inputs[each.name]!r} and {each!r} differ: "
                "give one of them another name"
            )
    return inputs
