"""Springs, ropes, masses, user forces, joint springs and contacts: methods of `Scene`."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.force_elements.beam_contacts import make_beam_contact

__all__ = ["make_beam_contact"]

__getattr__ = on_demand(__name__, {"beam_contacts": "make_beam_contact"})
