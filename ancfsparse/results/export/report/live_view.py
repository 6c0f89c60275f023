"""The moving scene of a simulation in a browser, served to this computer alone."""

from __future__ import annotations

import base64
import secrets
import threading
import time
import weakref
import webbrowser
from contextlib import AbstractContextManager
from html import escape
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Protocol

import numpy as np

from ancfsparse.checks import check_count, check_flag
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results.export.report.moving_scene import make_moving_scene, trace_motion
from ancfsparse.results.export.report.notebook import HEIGHT
from ancfsparse.results.export.report.web_page import make_page
from ancfsparse.results.geometry.scene_outline import make_outline
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.system import System

HOST = "127.0.0.1"
MAX_FPS = 100  # frames per second, more than screens show
MAX_COST = 0.1  # time for frames, over the time of the simulation
CALLS_PER_FRAME = 8  # of `follow`, at most about as many
MAX_EVERY = 1 << 20  # steps between two calls
PING = 1.0  # s without a frame, after which a page is asked whether it is still there


class Stepped(Protocol):
    """A simulation that a view follows."""

    system: System
    _busy: AbstractContextManager[object]
    _calls: list[Any]

    @property
    def steps(self) -> int:
        """Number of steps taken."""
        ...

    @property
    def _states(self) -> StateHistory: ...


class LiveView:
    """A page that shows a simulation while it is stepped.

    Attributes
    ----------
    url : str
        Address of the page, on this computer only.
    every : int
        Steps after which the simulation calls `follow`, adapted to their duration.
    """

    def __init__(
        self, source: Stepped, fps: int = 25, port: int = 0, *, browser: bool = False
    ) -> None:
        if check_count("fps", fps) > MAX_FPS:
            raise InputError(f"fps must be at most {MAX_FPS}, got {format_value(fps)}")
        if isinstance(port, bool) or not isinstance(port, int) or not 0 <= port < 65536:
            raise InputError(f"port must be a number from 0 to 65535, got {format_value(port)}")
        check_flag("browser", browser)
        self.every = 1
        self._interval, self._due, self._last = 1.0 / fps, 0.0, 0.0
        self._source = weakref.ref(source)
        self._system, self._outline = source.system, make_outline(source.system)
        scene = make_moving_scene(self._system, self._outline, source._states)
        names = list(scene.moving)
        scene.contents["live"] = [[name, scene.moving[name].size] for name in names]
        self._changed = threading.Condition()
        self._pages, self._number, self._sent_steps, self._frame = 0, 0, -1, b""
        self._closed = threading.Event()
        page = make_page(scene, "simulation", live=True).encode()
        self._path = f"/{secrets.token_urlsafe(12)}/"
        try:
            self._server = _Server((HOST, port), _make_handler(self, page))
        except OSError as error:
            raise InputError(
                f"port {port} of {HOST} cannot be used ({error.strerror}): take another, or 0 for "
                "any that is free"
            ) from error
        self.url = f"http://{HOST}:{self._server.server_port}{self._path}"
        for work in (self._serve, self._show_pauses):
            threading.Thread(target=work, daemon=True).start()
        weakref.finalize(source, self.close).atexit = False
        if browser:
            webbrowser.open(self.url)

    def __repr__(self) -> str:
        """Name the address."""
        return f"LiveView: {'closed' if self._closed.is_set() else self.url}"

    def __enter__(self) -> LiveView:
        """Return itself."""
        return self

    def __exit__(self, *error: object) -> None:
        """Close the page."""
        self.close()

    def _repr_html_(self) -> str:
        """Return a frame with the page, for a notebook on this computer."""
        return (
            f'<iframe src="{escape(self.url)}" '
            f'style="width: 100%; height: {HEIGHT}px; border: 0"></iframe>'
        )

    def close(self) -> None:
        """Stop following the simulation; an open page keeps its last picture."""
        self._closed.set()
        source = self._source()
        if source is not None and self in source._calls:
            source._calls.remove(self)
        with self._changed:
            self._changed.notify_all()

    @property
    def is_open(self) -> bool:
        """True until it is closed."""
        return not self._closed.is_set()

    def follow(self, source: Stepped) -> None:
        """Send the present state to the page, if it is time for a frame."""
        now = time.perf_counter()
        passed, self._last = now - self._last, now
        if passed < self._interval / CALLS_PER_FRAME:
            self.every = min(2 * self.every, MAX_EVERY)
        elif passed > 2.0 * self._interval / CALLS_PER_FRAME and self.every > 1:
            self.every //= 2
        if self._pages and now >= self._due:
            self._send(source)

    def _serve(self) -> None:
        """Answer requests until the view is closed."""
        with self._server:
            while self.is_open:
                self._server.handle_request()

    def _send(self, source: Stepped) -> None:
        """Send the present state."""
        begin = time.perf_counter()
        states, steps = source._states, source.steps
        moving = trace_motion(self._system, self._outline, states).moving
        values = np.concatenate([states.t, *(table.ravel() for table in moving.values())])
        frame = base64.b64encode(values.astype("<f4").tobytes())
        with self._changed:
            self._frame = b"data: %.17g %s\n\n" % (states.t[0], frame)
            self._number, self._sent_steps = self._number + 1, steps
            self._changed.notify_all()
        now = time.perf_counter()
        self._due = begin + max(self._interval, (now - begin) / MAX_COST)

    def _show_pauses(self) -> None:
        """Send the present state when no call of `follow` came for a frame."""
        while not self._closed.wait(self._interval):
            source = self._source()
            if source is None:
                return
            now = time.perf_counter()
            is_due = now >= self._due and now - self._last > self._interval
            if self._pages and is_due and source.steps != self._sent_steps:
                with source._busy:
                    self._send(source)
            del source  # it ends with its last other reference


class _Server(ThreadingHTTPServer):
    """A server whose threads end with the process."""

    daemon_threads = True
    block_on_close = False
    timeout = 0.1  # s without a request, after which it is asked whether the view is open


def _make_handler(view: LiveView, page: bytes) -> type[BaseHTTPRequestHandler]:
    """Return the class that answers requests for a view."""

    class Handler(BaseHTTPRequestHandler):
        def log_message(self, format: str, *args: Any) -> None:
            """Omit the log."""

        def do_GET(self) -> None:
            """Answer with the page, or with frames until the view is closed."""
            own = {f"{name}:{view._server.server_port}" for name in (HOST, "localhost")}
            if self.headers.get("Host") not in own:  # a page elsewhere that got this address
                self.send_error(403, "this page is for this computer only")
            elif self.path == view._path:
                self._begin("text/html; charset=utf-8")
                self.wfile.write(page)
            elif self.path == f"{view._path}frames":
                self._begin("text/event-stream")
                try:
                    self._send_frames()
                except OSError:  # the page was closed
                    pass
            else:
                self.send_error(404)

        def _begin(self, kind: str) -> None:
            self.send_response(200)
            for name, value in (("Content-Type", kind), ("Cache-Control", "no-store")):
                self.send_header(name, value)
            self.end_headers()

        def _send_frames(self) -> None:
            sent = 0
            with view._changed:
                view._pages += 1
                view._sent_steps = -1  # the present state, also for this page
            try:
                while view.is_open:
                    with view._changed:
                        if view._number == sent and view.is_open:
                            view._changed.wait(PING)
                        text = view._frame if view._number > sent else b": still there\n\n"
                        sent = view._number
                    self.wfile.write(text)
                self.wfile.write(b"event: end\ndata: end\n\n")
            finally:
                with view._changed:
                    view._pages -= 1

    return Handler
