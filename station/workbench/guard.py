"""The guard at the door: who may speak to the server, and what its pages may fetch.

A page of another site can reach a server on 127.0.0.1: by a name that it points there (DNS rebinding), or by opening
a websocket. Both show in their headers.
"""

from collections.abc import Iterable
from ipaddress import ip_address
from urllib.parse import urlsplit

from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

PAGE = "; ".join(
    (
        "default-src 'self'",
        "script-src 'self' 'unsafe-inline' 'unsafe-eval'",
        "style-src 'self' 'unsafe-inline'",
        "img-src 'self' data: blob:",
        "font-src 'self' data:",
        "connect-src 'self' {socket}",
        "frame-src 'self'",
        "worker-src 'self' blob:",
        "object-src 'none'",
        "base-uri 'self'",
        "form-action 'self'",
        "frame-ancestors 'self'",
    )
)
"""NiceGUI's templates are compiled in the browser, which needs 'unsafe-eval'; nothing may come from elsewhere."""


class Guard:
    """ASGI middleware: refuses foreign names and origins, and adds the Content-Security-Policy."""

    def __init__(self, app: ASGIApp, names: Iterable[str], any_address: bool = False) -> None:
        """Let in the host `names` (with port); with `any_address` any that is a plain IP address."""
        self._app = app
        self._names = {name.lower() for name in names}
        self._any_address = any_address

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on what may pass."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {key.decode("latin-1"): value.decode("latin-1") for key, value in scope["headers"]}
        host = headers.get("host", "").lower()
        if not self._known(host) or not _own_origin(headers.get("origin"), host):
            await _refuse(scope, receive, send)
            return

        async def with_policy(message: Message) -> None:
            if message["type"] == "http.response.start":
                policy = PAGE.format(socket=f"ws://{host}")
                message["headers"] = [
                    *message.get("headers", ()),
                    (b"content-security-policy", policy.encode("latin-1")),
                    (b"x-content-type-options", b"nosniff"),
                    (b"referrer-policy", b"no-referrer"),
                ]
            await send(message)

        await self._app(scope, receive, with_policy)

    def _known(self, host: str) -> bool:
        if host in self._names:
            return True
        return self._any_address and _is_address(urlsplit(f"//{host}").hostname or "")


def _own_origin(origin: str | None, host: str) -> bool:
    return origin is None or origin.lower() in (f"http://{host}", f"https://{host}")


def _is_address(name: str) -> bool:
    try:
        ip_address(name)
    except ValueError:
        return False
    return True


async def _refuse(scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008})
        return
    answer = PlainTextResponse("this workbench answers requests of its own page only\n", 403)
    await answer(scope, receive, send)
