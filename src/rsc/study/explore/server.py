"""`rsc.explore`: a page on this machine whose answers follow the values that are moved. Standard library alone.

The server listens on 127.0.0.1, answers only under a path that holds a random token, and only requests that name this very host
and come from its own page; it reads no file that a request names, and writes none.
"""

import hmac
import json
import secrets
import threading
from collections.abc import Callable
from dataclasses import asdict
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, ClassVar

from rsc.arguments import SCENE, WHOLE, takes
from rsc.errors import RscError, SolverError, one_line
from rsc.scene.scene import Scene
from rsc.show.page import LIBRARY
from rsc.study.explore.live import Job, Live

HERE = Path(__file__).parent
POLICY = "default-src 'none'; script-src 'self'; style-src 'unsafe-inline'; connect-src 'self'; img-src data: blob:"
MOST_BODY, MOST_AT_ONCE, PATIENCE = 100_000, 16, 10.0  # bytes; requests; s that a connection may say nothing
JSON = "application/json"


class Explorer:
    """A running page: `address` to open, `close()` to end it; also a context."""

    def __init__(self, scene: Scene, port: int = 0) -> None:
        self.live, self.job, self.token = Live(scene), Job(), secrets.token_urlsafe(24)
        self._lock = threading.Lock()
        try:
            self._server = _Server(("127.0.0.1", port), _Handler)
        except (OSError, OverflowError) as error:
            raise SolverError(f"port {port}: cannot be used ({str(getattr(error, 'strerror', error)).lower()})") from None
        self._server.explorer = self
        self.host = f"127.0.0.1:{self._server.server_address[1]}"
        self.address = f"http://{self.host}/{self.token}/"
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the page; requests are refused from then on."""
        self._server.shutdown()
        self._server.server_close()

    def wait(self) -> None:
        """Until the page is closed, or Ctrl-C."""
        while self._thread.is_alive():
            self._thread.join(0.5)

    def __enter__(self) -> "Explorer":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Explorer at {self.address}"

    def asked(self, part: str, asked: dict[str, Any]) -> dict[str, Any]:
        """What the page asks for; errors of rsc in words."""
        values = asked.get("values", {})
        if not isinstance(values, dict):
            return {"error": "values must be a table"}
        answers: dict[str, Callable[[], dict[str, Any]]] = {
            "begin": self._begin,
            "whirls": lambda: self.live.whirls(values),
            "words": lambda: self.live.words(values),
            "run": lambda: self.live.run(values),
            "map": lambda: self.live.map(values, str(asked.get("x")), str(asked.get("y"))),
            "toml": lambda: self.live.toml(values),
            "list": lambda: self._list(values),
            "listed": lambda: dict(self.job.told),
        }
        try:
            return answers[part]()
        except RscError as error:
            return {"error": str(error)}

    def _begin(self) -> dict[str, Any]:
        return {"title": one_line(self.live.scene.title) or "scene", "handles": [asdict(handle) for handle in self.live.handles]}

    def _list(self, values: dict[str, Any]) -> dict[str, Any]:
        self.live.moved(values)
        with self._lock:
            threading.Thread(target=self.job.run, args=(self.live, values), daemon=True).start()
        return {"state": "running"}


PARTS = ("begin", "whirls", "words", "run", "map", "toml", "list", "listed")


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    explorer: Explorer

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.room = threading.BoundedSemaphore(MOST_AT_ONCE)

    def handle_error(self, *_: object) -> None:
        """A connection that broke is nothing to the others."""


class _Handler(BaseHTTPRequestHandler):
    """Answers to one connection."""

    timeout = PATIENCE
    server_version, sys_version = "rsc", ""
    server: _Server
    FILES: ClassVar[dict[str, tuple[str, str]]] = {
        "": ("explore.html", "text/html; charset=utf-8"),
        "explore.js": ("explore.js", "text/javascript; charset=utf-8"),
    }

    def do_GET(self) -> None:
        """The page and its scripts."""
        path = self._allowed()
        if path is None:
            return
        if path == "plotly.js":
            self._send(200, LIBRARY.read_bytes(), "text/javascript; charset=utf-8", [("Content-Encoding", "gzip")])
        elif path in self.FILES:
            name, kind = self.FILES[path]
            self._send(200, (HERE / name).read_bytes(), kind)
        else:
            self._send(404, b"not found\n")

    def do_POST(self) -> None:
        """A question of the page."""
        path = self._allowed()
        if path is None:
            return
        size = self.headers.get("Content-Length", "")
        if self.headers.get_content_type() != JSON or not size.isascii() or not size.isdigit() or int(size) > MOST_BODY:
            self._send(400, b"a question is JSON of limited size\n")
            return
        try:
            asked = json.loads(self.rfile.read(int(size)))
        except (ValueError, RecursionError):
            asked = None
        if not isinstance(asked, dict) or path not in PARTS:
            self._send(400, b"no such question\n")
            return
        if not self.server.room.acquire(blocking=False):
            self._send(503, b"busy\n")
            return
        try:
            answer = self.server.explorer.asked(path, asked)
        except Exception as error:
            answer = {"error": f"{type(error).__name__}: {error}"[:500]}
        finally:
            self.server.room.release()
        self._send(200, json.dumps(_finite(answer)).encode(), JSON)

    def _allowed(self) -> str | None:
        """The path behind the token, of a request of this very page; None where the request was refused."""
        explorer = self.server.explorer
        token, slash, path = self.path.removeprefix("/").partition("/")
        origin = self.headers.get("Origin")
        hosts = self.headers.get_all("Host") or []
        ours = hosts == [explorer.host] and origin in (None, f"http://{explorer.host}")
        if not ours or not slash or not hmac.compare_digest(token.encode(), explorer.token.encode()):
            self._send(403, b"refused\n")
            return None
        return path

    def _send(self, code: int, body: bytes, kind: str = "text/plain; charset=utf-8", more: Any = ()) -> None:
        self.send_response(code)
        fixed = {
            "Content-Type": kind, "Content-Length": str(len(body)), "Content-Security-Policy": POLICY,
            "X-Content-Type-Options": "nosniff", "X-Frame-Options": "DENY", "Referrer-Policy": "no-referrer",
            "Cache-Control": "no-store",
            "Cross-Origin-Resource-Policy": "same-origin",
        }  # fmt: skip
        for name, value in (*fixed.items(), *more):
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        """Nothing is told of requests."""


def _finite(value: Any) -> Any:
    """Numbers that JSON has; infinite ones and NaN are null."""
    if isinstance(value, dict):
        return {name: _finite(each) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(each) for each in value]
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and (value != value or abs(value) == float("inf")) else value


@takes(scene=SCENE, port=WHOLE)
def explore(scene: Scene, port: int = 0) -> Explorer:
    """Open a page on this machine on which values of a scene are moved, and whirls, orbit, spectrum and map follow.

    Parameters
    ----------
    scene : Scene
    port : int
        On 127.0.0.1; by default one that is free.

    Returns
    -------
    Explorer
        Its `address`, to be opened in a browser, holds a random token: without it every request is refused. `close()` ends it.

    Raises
    ------
    SolverError
        The port cannot be used.

    Examples
    --------
    >>> with rsc.explore(rsc.load_scene("laval.toml")) as page:
    ...     page.address.startswith("http://127.0.0.1:")
    True
    """
    return Explorer(scene, port)
