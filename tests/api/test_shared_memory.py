"""Images in shared memory: content, capacity, permissions and cleanup."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import grpc
import numpy as np
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_client.errors import ProtocolError
from arramon_client.observations import observation_of
from arramon_client.transport.images import ImagesUnreadableError
from arramon_client.transport.shared_memory import decoder_of, map_memory
from arramon_server.api.encoding import STANDARD_ENCODINGS
from arramon_server.api.encoding_choice import offered_encodings
from arramon_server.api.shared_memory import SharedImages, SharedMemoryEncoder
from tests import tiny
from tests.api.player import Player, create
from tests.serving import METADATA, Server

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="shared memory is offered on Linux only")

RANDOM = np.random.default_rng(5)
SHARED = types_pb2.ENCODING_SHARED


@pytest.fixture(scope="module")
def local(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    data = tmp_path_factory.mktemp("data")
    tiny.write(data)
    server = Server(data, f"unix:{data}/s", "--steps", "8")
    yield server
    assert server.stop() == 0


@pytest.fixture
def near(local: Server) -> Iterator[EvaluationStub]:
    with grpc.insecure_channel(local.address) as channel:
        yield EvaluationStub(channel)


def opened(encoder: SharedMemoryEncoder) -> pb.Opened:
    message = pb.Opened()
    encoder.announce(message)
    return message


def test_shared_image_is_readable_until_its_episode_overwrites_it() -> None:
    with SharedMemoryEncoder(2, ("depth", "rgb"), 4) as encoder:
        decoder = decoder_of(opened(encoder))
        shown = {}
        for episode_id in ("a", "b", "a"):
            rgb, depth = RANDOM.integers(0, 256, (4, 4, 3), np.uint8), RANDOM.integers(0, 65536, (4, 4), np.uint16)
            message = pb.Observation()
            encoder.encode(episode_id, [(rgb, message.rgb), (depth, message.depth)], latest=True)
            shown[episode_id] = rgb, depth, message
            assert not message.rgb.data
        for rgb, depth, message in shown.values():
            assert np.array_equal(decoder.rgb(message.rgb), rgb)
            assert np.array_equal(np.rint(decoder.depth(message.depth) * 1000.0), depth)
    assert np.array_equal(decoder.rgb(shown["a"][2].rgb), shown["a"][0])


def test_an_image_that_was_drawn_in_shared_memory_is_not_copied() -> None:
    with SharedMemoryEncoder(1, ("depth", "rgb"), 4) as encoder:
        decoder, message = decoder_of(opened(encoder)), pb.Observation()
        canvas = encoder.canvas("a")
        assert canvas is not None
        canvas.rgb[...], canvas.depth[...] = RANDOM.integers(0, 256, (4, 4, 3)), 1234
        encoder.encode("a", [(canvas.rgb, message.rgb), (canvas.depth, message.depth)], latest=True)
        assert np.array_equal(decoder.rgb(message.rgb), canvas.rgb)
        canvas.depth[...] = 5678  # seen through the message as there is only one copy
        assert np.allclose(decoder.depth(message.depth), 5.678)
        assert encoder.canvas("a") is canvas
        assert encoder.canvas("b") is None  # no room
        encoder.forget("a")
        assert encoder.canvas("b") is not None


@pytest.mark.parametrize(("sensors", "size"), [(("rgb",), 4), (("depth",), 4), ((), 4), (("rgb", "depth"), 5)])
def test_nothing_is_drawn_in_shared_memory_that_cannot_be(sensors: tuple[str, ...], size: int) -> None:
    with SharedMemoryEncoder(1, sensors, size) as encoder:
        assert encoder.canvas("a") is None


def test_decoded_images_survive_later_writes() -> None:
    with SharedMemoryEncoder(1, ("rgb",), 4) as encoder:
        message = pb.Observation()
        encoder.encode("a", [(np.full((4, 4, 3), 7, np.uint8), message.rgb)], latest=True)
        seen = observation_of(message, decoder_of(opened(encoder))).rgb
        encoder.encode("a", [(np.zeros((4, 4, 3), np.uint8), message.rgb)], latest=True)
    assert seen is not None
    assert (seen == 7).all()


def test_shared_memory_holds_every_open_episode() -> None:
    def encoding(episode_id: str, *, latest: bool = True) -> int:
        image = types_pb2.Image()
        encoder.encode(episode_id, [(np.zeros((4, 4, 3), np.uint8), image)], latest=latest)
        return image.encoding

    with SharedMemoryEncoder(2, ("rgb",), 4) as encoder:
        raw = types_pb2.ENCODING_RAW
        assert [encoding(each) for each in ("a", "b", "c", "a")] == [SHARED, SHARED, raw, SHARED]
        assert encoding("a", latest=False) == raw
        encoder.forget("a")
        encoder.forget("nobody")
        assert encoding("c") == SHARED


def test_an_image_outside_the_memory_is_refused() -> None:
    with SharedMemoryEncoder(1, ("rgb",), 4) as encoder:
        decoder = decoder_of(opened(encoder))
        image = types_pb2.Image(height=4, width=4, encoding=SHARED, place=96)
        with pytest.raises(ProtocolError, match="an image of 48 bytes at 96 is outside the shared memory of 128"):
            decoder.rgb(image)


def test_shared_memory_is_private_and_cannot_be_truncated() -> None:
    shared = SharedImages(1, 48)
    assert os.fstat(shared.message.descriptor).st_mode & 0o777 == 0o600
    with pytest.raises(PermissionError):
        os.ftruncate(shared.message.descriptor, 0)
    assert map_memory(shared.message).readonly


@pytest.mark.parametrize(("changed", "said"), [
    ({"token": b"0" * 16}, "is not the memory"), ({"token": b""}, "is not the memory"),
    ({"size": 64}, "is not the memory"), ({"descriptor": 10_000}, "cannot be read"),
    ({"process": 4_000_000_000}, "cannot be read"), ({"descriptor": 0}, "cannot be read|is not the memory"),
])  # fmt: skip
def test_mapping_mismatched_shared_memory_is_refused(changed: dict[str, int | bytes], said: str) -> None:
    shared = SharedImages(1, 48)
    message = types_pb2.SharedMemory()
    message.CopyFrom(shared.message)
    for name, value in changed.items():
        setattr(message, name, value)
    with pytest.raises(ImagesUnreadableError, match=said):
        map_memory(message)


@pytest.mark.parametrize(("listen", "encodings"), [
    ("unix:/tmp/s", (*STANDARD_ENCODINGS, SHARED)),
    ("127.0.0.1:0", STANDARD_ENCODINGS),
    ("0.0.0.0:50551", STANDARD_ENCODINGS),
])  # fmt: skip
def test_shared_memory_is_offered_on_unix_sockets_only(
    listen: str, encodings: tuple[types_pb2.Encoding.ValueType, ...]
) -> None:
    assert offered_encodings(listen) == encodings


def test_shared_memory_and_messages_give_identical_images(near: EvaluationStub) -> None:
    info = near.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA)
    assert SHARED in info.encodings
    sensors = ["rgb", "depth", "segmentation"]
    shown: dict[int, list[bytes]] = {}
    for encoding in (types_pb2.ENCODING_RAW, SHARED):
        run = create(near, episodes=1, sensors=sensors)
        with Player(near, run.run_id, encoding=encoding, image_size=128) as player:
            opened = player.next().opened
            decoder = decoder_of(opened)
            shown[encoding] = []
            for step, action in enumerate(tiny.ACTIONS):
                message = player.observation()
                seen = observation_of(message, decoder)
                images = (seen.rgb, seen.depth, seen.segmentation)
                assert all(getattr(message, name).encoding == encoding for name in sensors)
                shown[encoding] += [image.tobytes() for image in images if image is not None]
                player.act(message.episode_id, step, action)
    assert len(shown[SHARED]) == 3 * len(tiny.ACTIONS)
    assert shown[SHARED] == shown[types_pb2.ENCODING_RAW]


def test_history_images_are_sent_in_messages(near: EvaluationStub) -> None:
    run = create(near, episodes=1, sensors=["rgb"])
    with Player(near, run.run_id, player="one", encoding=SHARED) as player:
        first = player.observation()
        for step, action in enumerate(tiny.ACTIONS[:2]):
            player.act(first.episode_id, step, action)
            player.observation()
    with Player(near, run.run_id, player="one", encoding=SHARED, history=True) as player:
        again = [player.observation() for _ in range(3)]
    raw = types_pb2.ENCODING_RAW
    assert [(o.step, o.rgb.encoding) for o in again] == [(0, raw), (1, raw), (2, SHARED)]


def test_killed_server_leaves_no_mappable_shared_memory(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path, f"unix:{tmp_path}/s")
    with grpc.insecure_channel(server.address) as channel:
        stub = EvaluationStub(channel)
        run = create(stub, episodes=1, sensors=["rgb"])
        with Player(stub, run.run_id, encoding=SHARED) as player:
            message = player.next().opened.shared
            memory = map_memory(message)
            server.kill()
    with pytest.raises(ImagesUnreadableError):
        map_memory(message)
    assert bytes(memory[: len(message.token)]) == message.token  # For whoever still looks at it.
