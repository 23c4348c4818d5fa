"""Half-open connections: detected by keepalive, their episodes freed for the run's next stream."""

import asyncio
import threading
from contextlib import suppress
from pathlib import Path

import grpc

from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from tests import tiny
from tests.api.player import Player, create
from tests.serving import Server


class Relay:
    """A TCP relay that can fall silent without closing anything: what a half-open connection is."""

    def __init__(self, address: str) -> None:
        self._host, _, port = address.rpartition(":")
        self._port = int(port)
        self.silent = False
        self.closed_by_server = threading.Event()
        self._ready = threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve()), daemon=True)
        self._thread.start()
        self._ready.wait()

    async def _serve(self) -> None:
        self._loop, self._stop = asyncio.get_running_loop(), asyncio.Event()
        server = await asyncio.start_server(self._accept, "127.0.0.1", 0)
        self.address = f"127.0.0.1:{server.sockets[0].getsockname()[1]}"
        self._ready.set()
        await self._stop.wait()
        server.close()

    async def _accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        back_reader, back_writer = await asyncio.open_connection(self._host, self._port)
        there = asyncio.create_task(self._carry(reader, back_writer))
        await self._carry(back_reader, writer)
        self.closed_by_server.set()
        there.cancel()
        writer.close()
        back_writer.close()

    async def _carry(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with suppress(ConnectionError):
            while data := await reader.read(1 << 16):
                if not self.silent:
                    writer.write(data)

    def stop(self) -> None:
        self._loop.call_soon_threadsafe(self._stop.set)
        self._thread.join()


def test_half_open_connection_frees_its_episodes_for_the_next_stream(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path, "127.0.0.1:0", "--keepalive-seconds", "1")
    relay = Relay(server.address)
    with grpc.insecure_channel(server.address) as channel, grpc.insecure_channel(relay.address) as lost:
        stub = EvaluationStub(channel)
        run = create(stub, episodes=1)
        with Player(EvaluationStub(lost), run.run_id, player="lost") as silent:
            episode_id = silent.observation().episode_id
            with Player(stub, run.run_id, player="next", adopt=True) as player:
                assert not player.next().opened.episode_ids  # it is held
            relay.silent = True
            assert relay.closed_by_server.wait(240)  # the keepalive found nobody
            with Player(stub, run.run_id, player="next", adopt=True) as player:
                assert player.next().opened.episode_ids == [episode_id]
                player.observation()
    relay.stop()
    assert server.stop() == 0
