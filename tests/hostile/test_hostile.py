"""Hostile clients over a real port, of bounded size, beside a client that must be unaffected."""

import socket
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_server.api.error_guard import INTERNAL_ERROR_TEXT
from arramon_server.api.play_stream import MAX_ACTS
from tests.hostile.attacks import REQUESTS, Attacker, play_message, sockets
from tests.hostile.conftest import Neighbour, beside, memory
from tests.serving import METADATA, Server

PROPER = {
    grpc.StatusCode.OK,
    grpc.StatusCode.INVALID_ARGUMENT,
    grpc.StatusCode.NOT_FOUND,
    grpc.StatusCode.FAILED_PRECONDITION,
    grpc.StatusCode.RESOURCE_EXHAUSTED,
    grpc.StatusCode.UNIMPLEMENTED,
    grpc.StatusCode.UNAUTHENTICATED,
    grpc.StatusCode.PERMISSION_DENIED,
}
STREAM = 8
"""MiB that a stream may hold whose client reads nothing: what waits to leave, and what gRPC has taken of it."""

GROWTH = 96
"""MiB by which a server's memory may grow under one attack; most of it is what Python and gRPC do not give back."""

INSIDE = (
    "Traceback",
    'File "',
    "sqlalchemy",
    "sqlite3",
    "psycopg",
    ".py",
    "<class",
    "object at 0x",
    INTERNAL_ERROR_TEXT,
)
"""What no refusal may hold."""


@dataclass
class Attack:
    """What a test of this file attacks with, and what must hold afterwards.

    Attributes:
        neighbour: who plays beside the attacker.
    """

    server: Server
    undisturbed: pb.Report
    seed: int
    neighbour: Neighbour = field(init=False)

    @contextmanager
    def attacker(self) -> Iterator[Attacker]:
        """An attacker beside a neighbour: it is answered properly, and neither the neighbour nor memory suffers."""
        before = memory(self.server)
        with (
            beside(self.server, self.undisturbed) as self.neighbour,
            closing(Attacker(self.server.address, self.seed)) as attacker,
        ):
            yield attacker
        assert attacker.statuses
        assert set(attacker.statuses) <= PROPER, attacker.statuses
        assert not [details for details in attacker.details for word in INSIDE if word in details]
        assert memory(self.server) < before + GROWTH + attacker.streams_unread * STREAM


@pytest.fixture
def attack(server: Server, undisturbed: pb.Report, request: pytest.FixtureRequest) -> Attack:
    return Attack(server, undisturbed, seed=len(request.node.name))


def new_run(attacker: Attacker, sensors: tuple[str, ...] = ()) -> str:
    request = pb.CreateRunRequest(agent="hostile", split="tiny", language="en", sensors=sensors)
    answer = attacker.unary("CreateRun", request.SerializeToString())
    assert answer is not None
    return pb.Run.FromString(answer).run_id


def held_open(messages: list[bytes], done: threading.Event) -> Iterator[bytes]:
    """These messages, on a stream that its client does not end before `done`, or four minutes."""
    yield from messages
    done.wait(240)


def test_server_survives_random_bytes(attack: Attack) -> None:
    with attack.attacker() as attacker:
        for _ in range(30):
            for method in REQUESTS:
                attacker.unary(method, attacker.bytes_())
            attacker.play([attacker.bytes_()])
        assert attacker.statuses[grpc.StatusCode.INVALID_ARGUMENT] > 30


def test_server_survives_odd_field_values(attack: Attack) -> None:
    with attack.attacker() as attacker:
        for _ in range(25):
            for method, message in REQUESTS.items():
                attacker.unary(method, attacker.filled(message()).SerializeToString())
        assert attacker.statuses[grpc.StatusCode.INVALID_ARGUMENT] > 0
        assert attacker.statuses[grpc.StatusCode.NOT_FOUND] > 12


def test_server_survives_mutated_messages(attack: Attack) -> None:
    with attack.attacker() as attacker:
        run_id = new_run(attacker)
        known = {
            "CreateRun": pb.CreateRunRequest(agent="a", split="tiny", language="en", sensors=["rgb"], episodes=2),
            "GetRun": pb.GetRunRequest(run_id=run_id),
            "ListRuns": pb.ListRunsRequest(page_size=3, page_token=run_id),
            "GetReport": pb.GetReportRequest(run_id=run_id),
        }
        for _ in range(80):
            for method, message in known.items():
                attacker.unary(method, attacker.mutated(message.SerializeToString()))
        opening = play_message(run_id=run_id, max_episodes=2, player="p")
        acting = play_message([pb.Act(episode_id="0", step=0, action=types_pb2.ACTION_FORWARD)])
        for _ in range(40):
            attacker.play([attacker.mutated(opening), attacker.mutated(acting)])


def test_messages_in_the_wrong_order_are_refused(attack: Attack) -> None:
    with attack.attacker() as attacker:
        opening = play_message(run_id=new_run(attacker), max_episodes=2)
        acting = play_message([pb.Act(episode_id="0", step=0, action=types_pb2.ACTION_LEFT)])
        for messages in (
            [],
            [b""],
            [acting],
            [acting, opening],
            [opening, opening],
            [opening, b""],
            [opening, b"\xff"],
        ):
            attacker.play(messages)
        assert attacker.statuses[grpc.StatusCode.INVALID_ARGUMENT] == 7


def test_odd_actions_are_problems_and_the_stream_continues(attack: Attack) -> None:
    with attack.attacker() as attacker:
        run_id = new_run(attacker)
        acts = [pb.Act(episode_id="1") for _ in range(1000)]
        for act in acts:
            attacker.filled(act)
        odd = [play_message(acts[start : start + 10]) for start in range(0, 1000, 10)]  # none is too large
        answers = attacker.play([play_message(run_id=run_id, max_episodes=6), *odd])
        events = [event for answer in answers for event in pb.PlayResponse.FromString(answer).events]
        assert {"opened", "problem"} <= {event.WhichOneof("event") for event in events}
        assert attacker.statuses[grpc.StatusCode.OK] == 2


def test_oversized_messages_are_refused(attack: Attack, server: Server) -> None:
    with attack.attacker() as attacker:
        for _ in range(10):
            attacker.unary("CreateRun", pb.CreateRunRequest(agent="a" * (2 << 20)).SerializeToString())
        assert attacker.statuses == {grpc.StatusCode.RESOURCE_EXHAUSTED: 10}
        opening = play_message(run_id=new_run(attacker), max_episodes=1)
        attacker.play([opening, play_message([pb.Act()] * (MAX_ACTS + 1))])
        assert attacker.statuses[grpc.StatusCode.INVALID_ARGUMENT] == 1
        assert f"at most {MAX_ACTS} are allowed" in str(attacker.details)


def test_every_action_of_a_flood_is_answered(attack: Attack) -> None:
    """Each message is answered with 4,096 problems; the server reads no faster than it answers."""
    with attack.attacker() as attacker:
        flood = [play_message([pb.Act()] * MAX_ACTS)] * 5

        def answered(run_id: str) -> int:
            done = threading.Event()
            stream = attacker.stream(held_open([play_message(run_id=run_id, max_episodes=1), *flood], done))
            problems = 0
            for answer in stream:
                problems += sum(event.HasField("problem") for event in pb.PlayResponse.FromString(answer).events)
                if problems == len(flood) * MAX_ACTS:
                    break
            done.set()
            stream.cancel()
            return problems

        with ThreadPoolExecutor(4) as pool:
            runs = [new_run(attacker) for _ in range(4)]
            assert list(pool.map(answered, runs)) == [len(flood) * MAX_ACTS] * 4


def test_every_call_of_a_flood_is_answered(attack: Attack) -> None:
    with attack.attacker() as attacker:
        with ThreadPoolExecutor(16) as pool:
            list(pool.map(lambda _: attacker.unary("GetServerInfo", b""), range(1000)))
        assert attacker.statuses[grpc.StatusCode.OK] == 1000


def test_clients_that_do_not_read_do_not_disturb_others(attack: Attack) -> None:
    """Each asks for the largest images of all episodes, again and again, and takes none of them."""
    with attack.attacker() as attacker:
        again = play_message([pb.Act(episode_id=str(i), step=0, action=types_pb2.ACTION_LEFT) for i in range(6)])
        done = threading.Event()
        streams = []
        attacker.streams_unread = 12
        for _ in range(attacker.streams_unread):
            opening = play_message(
                run_id=new_run(attacker, ("rgb", "depth")), max_episodes=6, encoding="ENCODING_RAW", image_size=224
            )
            streams.append(attacker.stream(held_open([opening] + [again] * 200, done), timeout=240))
        attack.neighbour.play_on(3)
        done.set()
        for stream in streams:
            stream.cancel()


def test_a_thousand_streams_do_not_disturb_others(attack: Attack, server: Server) -> None:
    """A thousand at once, most of which never say what they want."""
    with attack.attacker() as attacker:
        run_id = new_run(attacker)
        done = threading.Event()
        others = [Attacker(server.address, seed) for seed in range(10)]
        try:
            streams = [each.stream(held_open([], done), timeout=240) for each in others for _ in range(90)]
            for number in range(100):
                opening = play_message(run_id=run_id, max_episodes=1, player=f"p{number}")
                streams.append(attacker.stream(held_open([opening], done), timeout=240))
            attack.neighbour.play_on(1)
        finally:
            done.set()
            for stream in streams:
                stream.cancel()
            for each in others:
                each.close()


def test_malformed_connections_do_not_disturb_others(attack: Attack, server: Server) -> None:
    """Bytes that are not HTTP/2, halves of it, and nothing at all."""
    with attack.attacker() as attacker:
        preface = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
        words = [b"", b"GET / HTTP/1.1\r\nHost: x\r\n\r\n", b"\x16\x03\x01\x02\x00\x01", preface, preface + b"\x00" * 9]
        words += [preface + b"\xff\xff\xff\x01\xff" + attacker.bytes_(1000), attacker.bytes_(5000)]
        with ExitStack() as stack:
            for connection in sockets(server.address, words * 40):
                stack.enter_context(connection)
        assert attacker.unary("GetServerInfo", b"") is not None


def test_server_survives_odd_metadata(attack: Attack) -> None:
    with attack.attacker() as attacker:
        for metadata in (
            (),
            (("arramon-protocol", "0"),),
            (("arramon-protocol", "1"), ("arramon-protocol", "2")),
            (*METADATA, ("authorization", "Bearer " + "x" * 4000)),
            (*METADATA, ("authorization", "")),
            (*METADATA, ("x-bin", b"\x00\xff" * 500)),
        ):
            for method in REQUESTS:
                attacker.unary(method, b"", metadata)


def test_half_closed_connections_do_not_block_the_server(server: Server, undisturbed: pb.Report) -> None:
    with beside(server, undisturbed):
        for connection in sockets(server.address, [b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"] * 50):
            connection.shutdown(socket.SHUT_WR)
            connection.close()
