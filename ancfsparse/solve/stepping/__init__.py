"""Time stepping: set-up, recording, recovery; what few runs need is loaded on first use."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.solve.stepping.file_recording import (
        check_file,
        continue_file,
        read_recorded,
        record_to_file,
        remove_checkpoint,
    )
    from ancfsparse.solve.stepping.remedies import hint_for_fixed_steps

__all__ = [
    "check_file",
    "continue_file",
    "hint_for_fixed_steps",
    "read_recorded",
    "record_to_file",
    "remove_checkpoint",
]

__getattr__ = on_demand(
    __name__,
    {
        "file_recording": (
            "check_file continue_file read_recorded record_to_file remove_checkpoint"
        ),
        "remedies": "hint_for_fixed_steps",
    },
)
