"""Cost without a clock: what the interpreter does, counted."""

import sys


def operations(action):
    """Count the operations of the interpreter in an action, called without arguments."""
    count = 0

    def trace(frame, event, _):
        nonlocal count
        frame.f_trace_opcodes = True
        count += event == "opcode"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        action()
    finally:
        sys.settrace(before)
    return count
