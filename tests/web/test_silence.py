"""Connections over which nothing whole is asked."""

import asyncio

import pytest
from aiohttp import web

from server.web import silence
from server.web.silence import Silence


def test_who_never_ends_a_request_is_sent_away_and_who_waits_for_an_answer_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(silence, "SILENT_SECONDS", 0.2)

    async def late(_: web.Request) -> web.Response:
        await asyncio.sleep(1.0)
        return web.Response(text="late")

    async def ask(port: int, words: bytes) -> bytes:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        writer.write(words)
        answer = await reader.read()
        writer.close()
        return answer

    async def serve() -> list[bytes]:
        kept = Silence()
        app = web.Application(middlewares=[kept.heard])
        app.add_routes([web.get("/", late)])
        runner = web.AppRunner(app)
        await runner.setup()
        try:
            await web.TCPSite(runner, "127.0.0.1", 0).start()
            assert runner.server is not None
            port = runner.addresses[0][1]
            async with kept.ended(runner.server):
                words = (b"", b"GET / HTTP/1.1\r\nHost: x\r\nA: ", b"GET / HTTP/1.1\r\nHost: x\r\n\r\n")
                return await asyncio.wait_for(asyncio.gather(*(ask(port, said) for said in words)), 20)
        finally:
            await runner.cleanup()

    nothing, half, whole = asyncio.run(serve())
    assert (nothing, half) == (b"", b"")
    assert whole.endswith(b"late")  # and then closed, as nothing more was asked
