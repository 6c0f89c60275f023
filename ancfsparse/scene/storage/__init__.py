"""Files, copies, digest, printing of a scene."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.storage.copies import counterpart, refined, replaced
    from ancfsparse.scene.storage.printing import format_record
    from ancfsparse.scene.storage.scene_file import load, save

__all__ = ["counterpart", "format_record", "load", "refined", "replaced", "save"]

__getattr__ = on_demand(
    __name__,
    {
        "copies": "counterpart refined replaced",
        "scene_file": "load save",
        "printing": "format_record",
    },
)
