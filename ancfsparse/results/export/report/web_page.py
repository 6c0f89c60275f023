"""One web page with all that it needs: styles, the script, three.js and the data of a scene."""

from __future__ import annotations

import base64
import hashlib
import re
from functools import cache
from importlib.resources import files

from ancfsparse.results.export.report.moving_scene import MovingScene
from ancfsparse.results.export.report.packing import compress, pack

FOLDER = files("ancfsparse.results.export.report") / "page"
SOURCE_MAP = "//# sourceMappingURL"  # of three.js, a file that is not part of the page


def make_page(
    scene: MovingScene, title: str, header: str = "", body: str = "", *, live: bool = False
) -> str:
    """Return a page with a moving scene.

    Parameters
    ----------
    scene : MovingScene
        The scene.
    title : str
        Title of the page, as HTML.
    header, body : str, optional
        HTML above and below the scene; without a body the scene fills the page.
    live : bool, optional
        Allow the page to get frames from the server that it comes from.

    Returns
    -------
    str
        The page.  Its policy allows the script whose digest it states, the modules that this
        script makes of the page itself, and inline styles; it cannot load anything.
    """
    script = (FOLDER / "page.js").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    parts = {
        "HASH": digest,
        "CONNECT": "; connect-src 'self'" if live else "",
        "TITLE": title,
        "STYLE": (FOLDER / "page.css").read_text(encoding="utf-8"),
        "CLASS": "" if body else "fragment",
        "HEADER": header,
        "BODY": body,
        "LIBRARY": _library(),
        "DATA": pack(scene.contents, scene.moving, scene.fixed),
        "SCRIPT": script,
    }
    template = (FOLDER / "page.html").read_text(encoding="utf-8")
    return re.sub(f"@({'|'.join(parts)})@", lambda match: parts[match[1]], template)


@cache
def _library() -> str:
    """Return three.js with its licence, compressed."""
    library = (FOLDER / "three.js").read_text(encoding="utf-8").partition(SOURCE_MAP)[0]
    licence = (FOLDER / "three-licence.txt").read_text(encoding="utf-8")
    return compress(f"/*\n{licence}*/\n{library}".encode())
