"""Responses in their wire format: what protobuf reads from them."""

import numpy as np
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.types_pb2 import ENCODING_RAW, ENCODING_SHARED, Image
from arramon_server.api.wire import Data, observation_event, response_of

PIXELS = np.arange(12, dtype=np.uint8)


@pytest.mark.parametrize("length", [0, 1, 127, 128, 16_383, 16_384, 300_000])
def test_a_response_is_what_protobuf_would_write(length: int) -> None:
    data = bytes(number % 251 for number in range(length))
    expected = pb.PlayResponse()
    started = expected.events.add()
    started.episode_started.episode_id = "1"
    observation = expected.events.add().observation
    observation.episode_id, observation.step, observation.instruction = "1", 300, "बाएँ मुड़ें।" * 20
    observation.pose.x = 1.5
    alone = pb.Observation()
    alone.CopyFrom(observation)
    images: list[tuple[str, Image, Data]] = []
    for name in ("rgb", "depth", "segmentation"):
        image = getattr(observation, name)
        image.height, image.width, image.encoding = 1, length, ENCODING_RAW
        head = Image()
        head.CopyFrom(image)
        image.data = data
        images.append((name, head, data))
    written = response_of([[started.SerializeToString()], observation_event(alone, images)])
    assert pb.PlayResponse.FromString(written) == expected


def test_views_of_pixels_are_written_as_bytes() -> None:
    written = response_of([observation_event(pb.Observation(), [("rgb", Image(), PIXELS.data)])])
    (event,) = pb.PlayResponse.FromString(written).events
    assert event.observation.rgb.data == PIXELS.tobytes()


def test_an_image_in_shared_memory_has_no_data() -> None:
    image = Image(height=2, width=2, encoding=ENCODING_SHARED, place=64)
    (event,) = pb.PlayResponse.FromString(
        response_of([observation_event(pb.Observation(), [("depth", image, b"")])])
    ).events
    assert event.observation.depth == image


def test_no_events_are_an_empty_response() -> None:
    assert pb.PlayResponse.FromString(response_of([])) == pb.PlayResponse()
