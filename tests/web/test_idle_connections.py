"""Idle connections: those that send no complete request are closed."""

import asyncio

import pytest
from aiohttp import web

from arramon_server.web import idle_connections
from arramon_server.web.idle_connections import IdleConnections


def test_only_connections_without_a_complete_request_are_closed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(idle_connections, "IDLE_SECONDS", 1.0)
    sent_away: list[bytes] = []

    async def late(_: web.Request) -> web.Response:
        while len(sent_away) < 2:  # and has then waited as long as they did
            await asyncio.sleep(0.01)
        return web.Response(text="late")

    async def ask(port: int, words: bytes) -> bytes:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        writer.write(words)
        answer = await reader.read()
        writer.close()
        sent_away.append(words)
        return answer

    async def serve() -> list[bytes]:
        connections = IdleConnections()
        app = web.Application(middlewares=[connections.middleware])
        app.add_routes([web.get("/", late)])
        runner = web.AppRunner(app)
        await runner.setup()
        try:
            await web.TCPSite(runner, "127.0.0.1", 0).start()
            assert runner.server is not None
            port = runner.addresses[0][1]
            async with connections.close_idle(runner.server):
                words = (b"", b"GET / HTTP/1.1\r\nHost: x\r\nA: ", b"GET / HTTP/1.1\r\nHost: x\r\n\r\n")
                return await asyncio.wait_for(asyncio.gather(*(ask(port, said) for said in words)), 120)
        finally:
            await runner.cleanup()

    nothing, half, whole = asyncio.run(serve())
    assert (nothing, half) == (b"", b"")
    assert whole.endswith(b"late")  # and then closed, as nothing more was asked
