"""The guard at the door: who may speak to the server, and what its pages may fetch.

A page of another site can reach a server on 127.0.0.1, and so can any other user of this computer: hence the token.
The address that is printed holds it; the first request with it is answered by a cookie and the address without it, and
no request of any kind passes without the one or the other. A browser sends the cookie to the name alone by which it got
it, so not to one that a site points here (DNS rebinding); but to every port, so that a foreign origin is refused.
"""

from secrets import compare_digest, token_urlsafe
from urllib.parse import quote, urlencode

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

LARGEST_BODY = 201 << 20
"""Bytes of one request: a file of 200 MB, and what the browser writes around it."""

OWN_PAGE = "this workbench answers requests of its own page only\n"
NO_TOKEN = "this workbench is opened by the address that it printed, with its token\n"
TOO_LARGE = "that is too large: at most 200 MB\n"

PAGE = "; ".join(
    (
        "default-src 'self'",
        "script-src 'self' 'nonce-{nonce}' 'unsafe-eval'",
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
"""What a page may fetch and run: nothing from elsewhere, and of scripts in the page itself those that the server wrote.

`unsafe-eval` stays: NiceGUI gives Vue its components as templates, which Vue compiles in the browser by `new Function`,
and sends its own calls as text that is evaluated. Inline styles stay: Quasar and ECharts write them.
"""


class Guard:
    """ASGI middleware: refuses foreign origins, who has no token, and what is too large; adds the policy."""

    def __init__(self, app: ASGIApp, token: str) -> None:
        self._app = app
        self._token = token.encode()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on what may pass."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        asked = HTTPConnection(scope)
        host = asked.headers.get("host", "").lower()
        answer = self._refusal(asked, host)
        if answer is not None and scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008})
        elif answer is not None:
            await answer(scope, receive, send)
        else:
            await self._app(scope, receive, _with_policy(send, host))

    def _refusal(self, asked: HTTPConnection, host: str) -> Response | None:
        """Return the answer to what may not pass; None to what may."""
        own = (f"http://{host}", f"https://{host}")
        if asked.headers.get("origin", own[0]).lower() not in own:
            return PlainTextResponse(OWN_PAGE, 403)
        cookie = f"workbench-{asked.scope['server'][1]}"  # a cookie is of a host, whatever the port
        if not self._is_token(asked.cookies.get(cookie, "")):
            return self._admission(asked, cookie) or PlainTextResponse(NO_TOKEN, 403)
        length = asked.headers.get("content-length", "0")
        unsaid = "transfer-encoding" in asked.headers  # no browser sends a file so
        if unsaid or not length.isdecimal() or len(length) > 15 or int(length) > LARGEST_BODY:
            return PlainTextResponse(TOO_LARGE, 413, {"connection": "close"})
        return None

    def _admission(self, asked: HTTPConnection, cookie: str) -> Response | None:
        """Return the cookie, and the address without its token, to who comes with the token; None to others."""
        if asked.scope.get("method") not in ("GET", "HEAD"):  # a websocket has none
            return None
        given = asked.query_params.multi_items()
        if not any(self._is_token(value) for name, value in given if name == "token"):
            return None
        rest = urlencode([(name, value) for name, value in given if name != "token"])
        place = "/" + quote(asked.scope["path"].lstrip("/\\"))
        answer = RedirectResponse(f"{place}?{rest}" if rest else place, 303, {"cache-control": "no-store"})
        answer.set_cookie(cookie, self._token.decode(), httponly=True, samesite="lax")
        return answer

    def _is_token(self, given: str) -> bool:
        return compare_digest(given.encode(), self._token)


def _with_policy(send: Send, host: str) -> Send:
    """Add the policy to every answer, and its nonce to the scripts of a page, so that no other script in it is run."""
    nonce = token_urlsafe(16)
    begun: Message = {}
    parts: list[bytes] = []

    async def with_policy(message: Message) -> None:
        nonlocal begun
        if message["type"] == "http.response.start":
            policy = PAGE.format(socket=f"ws://{host}", nonce=nonce)
            headers = MutableHeaders(scope=message)
            # A report has a stricter one.
            own = headers.setdefault("content-security-policy", policy) == policy
            headers["x-content-type-options"] = "nosniff"
            headers["referrer-policy"] = "no-referrer"
            if own and headers.get("content-type", "").startswith("text/html"):
                begun = message
                return
        elif begun and message["type"] == "http.response.body":
            parts.append(message.get("body", b""))
            if message.get("more_body"):
                return
            body = b"".join(parts).replace(b"<script", b'<script nonce="%b"' % nonce.encode())
            MutableHeaders(scope=begun)["content-length"] = str(len(body))
            await send(begun)
            message = {**message, "body": body}
        await send(message)

    return with_policy
