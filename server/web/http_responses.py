"""HTTP responses of the pages, with security headers, an ETag for caching, and compression."""

import gzip
import hashlib

from aiohttp import web

HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; style-src 'self'; script-src 'self'; img-src 'self'; font-src 'self'; connect-src 'self'; "
        "form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
    ),
    "Server": "ArraMon",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=()",
}

SHORT, DAY, FOR_EVER = "public, max-age=15", "public, max-age=86400", "public, max-age=31536000, immutable"

PRIVATE = "private, no-store"
"""`Cache-Control` of what not everybody may see."""

_SMALL = 600
"""Maximum size in bytes of a body that is sent uncompressed."""


def respond(
    request: web.BaseRequest,
    body: bytes,
    kind: str,
    *,
    status: int = 200,
    cache: str = SHORT,
    varies: str = "Accept-Encoding",
    name: str = "",
) -> web.Response:
    """Return a response with a body, or 304 if the browser has the body in its cache.

    Args:
        request: the request.
        body: uncompressed body.
        kind: content type, without the character set, which is UTF-8.
        status: HTTP status.
        cache: `Cache-Control` of the response.
        varies: request headers that the response depends on.
        name: file name for a download; empty for a page.
    """
    tag = f'W/"{hashlib.sha256(body).hexdigest()[:24]}"'
    headers = {**HEADERS, "Cache-Control": cache, "Vary": varies, "ETag": tag}
    if name:
        headers["Content-Disposition"] = f'attachment; filename="{name}"'
    if status == 200 and tag in (part.strip() for part in request.headers.get("If-None-Match", "").split(",")):
        return web.Response(status=304, headers=headers)
    if kind.startswith(("font/", "image/jpeg")):  # compressed already, and no text
        return web.Response(status=status, body=body, headers=headers, content_type=kind)
    if len(body) > _SMALL and _takes_gzip(request.headers.get("Accept-Encoding", "")):
        headers["Content-Encoding"] = "gzip"
        body = gzip.compress(body, 6, mtime=0)
    return web.Response(status=status, body=body, headers=headers, content_type=kind, charset="utf-8")


def redirect(address: str, *, varies: str = "") -> web.Response:
    """Return a redirect (303) to another page of this server."""
    headers = {**HEADERS, "Location": address, "Cache-Control": "no-cache"}
    if varies:
        headers["Vary"] = varies
    return web.Response(status=303, headers=headers)


def _takes_gzip(accepted: str) -> bool:
    codings = [part.strip().replace(" ", "") for part in accepted.split(",")]
    return any(coding.partition(";")[0] == "gzip" and not coding.endswith((";q=0", ";q=0.0")) for coding in codings)
