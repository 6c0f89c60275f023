"""Files, copies, digest, printing of a scene."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.storage.copies import counterpart, refined, replaced
    from ancfsparse.scene.storage.json_file import load, save
    from ancfsparse.scene.storage.printing import format_record

__all__ = ["counterpart", "format_record", "load", "refined", "replaced", "save"]

__getattr__ = on_demand(
    __name__,
    {
        "copies": "counterpart refined replaced",
        "json_file": "load save",
        "printing": "format_record",
    },
)
