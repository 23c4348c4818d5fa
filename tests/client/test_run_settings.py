"""Choice of a run's settings from the participant's options and what the server offers."""

import re

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client import UsageError, run_settings

INFO = pb.ServerInfo(
    splits=[
        pb.Split(name="train", episodes={"en": 9}, sensors=["rgb", "depth", "pose", "oracle"]),
        pb.Split(name="val_seen", episodes={"en": 9, "hi": 8}, sensors=["rgb", "depth", "pose", "oracle"]),
        pb.Split(name="test_unseen", episodes={"en": 9}, sensors=["rgb", "depth"], hidden=True),
    ],
    encodings=[types_pb2.ENCODING_ZSTD, types_pb2.ENCODING_RAW],
    image_sizes=[224, 128],
    max_episodes_per_stream=16,
)


@pytest.mark.parametrize(("language", "split", "name"), [
    ("hi", None, "val_seen"), ("hi", "val_seen", "val_seen"), ("en", "train", "train"),
])  # fmt: skip
def test_split_is_chosen_by_name_or_language(language: str, split: str | None, name: str) -> None:
    assert run_settings.choose_split(INFO, language, split).name == name


@pytest.mark.parametrize(("info", "language", "split", "said"), [
    (INFO, "fr", None, "no language 'fr'; it has en, hi"),
    (INFO, "fr", "train", "no language 'fr'; it has en, hi"),
    (INFO, "en", "val", "no split 'val'; it has test_unseen, train, val_seen"),
    (INFO, "hi", "train", "the split 'train' has no language 'hi'; it has en"),
    (INFO, "en", None, "several splits have the language 'en'; select one with --split: test_unseen, train, val_seen"),
    (pb.ServerInfo(), "en", None, "the server has no episodes"),
])  # fmt: skip
def test_unavailable_splits_and_languages_are_refused(
    info: pb.ServerInfo, language: str, split: str | None, said: str
) -> None:
    with pytest.raises(UsageError, match=re.escape(said)):
        run_settings.choose_split(info, language, split)


class Bare:
    def begin(self, episode: object) -> None: ...
    def act(self, observations: object) -> list[int]:
        return []


class Privileged(Bare):
    sensors = ("pose", "oracle")


@pytest.mark.parametrize(("agent", "asked", "split", "sensors"), [
    (Bare(), None, 0, ("rgb", "depth")), (Bare(), (), 0, ()), (Bare(), ("rgb",), 2, ("rgb",)),
    (Privileged(), None, 0, ("pose", "oracle")), (Privileged(), ("rgb",), 2, ("rgb",)),
])  # fmt: skip
def test_sensors_come_from_the_option_or_the_agent(
    agent: Bare, asked: tuple[str, ...] | None, split: int, sensors: tuple[str, ...]
) -> None:
    assert run_settings.choose_sensors(agent, asked, INFO.splits[split]) == sensors


def test_a_hidden_split_has_no_privileged_sensor() -> None:
    said = "the split 'test_unseen' does not offer the sensor oracle, pose; it offers depth, rgb"
    with pytest.raises(UsageError, match=said):
        run_settings.choose_sensors(Privileged(), None, INFO.splits[2])


@pytest.mark.parametrize("own", ["rgb", "rgb,depth", "", None, 3, ("rgb", 3), {"rgb": True}])
def test_invalid_sensors_attributes_are_refused(own: object) -> None:
    agent = Privileged()
    agent.sensors = own  # type: ignore[assignment]
    with pytest.raises(UsageError, match=r"the agent's attribute sensors is .*, expected a tuple of names") as refused:
        run_settings.choose_sensors(agent, None, INFO.splits[0])
    assert f"is {own!r}," in str(refused.value)
    assert run_settings.choose_sensors(agent, ("rgb",), INFO.splits[0]) == ("rgb",)


@pytest.mark.parametrize(("asked", "address", "encoding"), [
    (None, "unix:/tmp/s", types_pb2.ENCODING_RAW), (None, "localhost:1", types_pb2.ENCODING_RAW),
    (None, "[::1]:1", types_pb2.ENCODING_RAW), (None, "far.example:1", types_pb2.ENCODING_ZSTD),
    ("zstd", "unix:/tmp/s", types_pb2.ENCODING_ZSTD), ("raw", "far.example:1", types_pb2.ENCODING_RAW),
])  # fmt: skip
def test_encoding_depends_on_option_and_address(
    asked: str | None, address: str, encoding: types_pb2.Encoding.ValueType
) -> None:
    assert run_settings.choose_encoding(INFO, asked, address) == encoding


@pytest.mark.parametrize(("offered", "address", "encoding"), [
    ([types_pb2.ENCODING_JPEG, types_pb2.ENCODING_RAW], "far.example:1", types_pb2.ENCODING_RAW),
    ([types_pb2.ENCODING_JPEG, types_pb2.ENCODING_ZSTD], "unix:/tmp/s", types_pb2.ENCODING_ZSTD),
    ([types_pb2.ENCODING_JPEG, types_pb2.ENCODING_SHARED], "unix:/tmp/s", types_pb2.ENCODING_SHARED),
])  # fmt: skip
def test_lossy_encodings_are_used_only_on_request(
    offered: list[types_pb2.Encoding.ValueType], address: str, encoding: types_pb2.Encoding.ValueType
) -> None:
    assert run_settings.choose_encoding(pb.ServerInfo(encodings=offered), None, address) == encoding
    with pytest.raises(UsageError, match="no lossless encoding"):
        run_settings.choose_encoding(pb.ServerInfo(encodings=offered[:1]), None, address)


@pytest.mark.parametrize(("asked", "quality"), [(None, 0), (75, 75)])
def test_jpeg_quality_is_passed_on_or_left_to_the_server(asked: int | None, quality: int) -> None:
    assert run_settings.choose_jpeg_quality(types_pb2.ENCODING_JPEG, asked) == quality


def test_quality_requires_jpeg() -> None:
    assert run_settings.choose_jpeg_quality(types_pb2.ENCODING_RAW, None) == 0
    with pytest.raises(UsageError, match="--quality requires --encoding jpeg"):
        run_settings.choose_jpeg_quality(types_pb2.ENCODING_ZSTD, 75)


@pytest.mark.parametrize(
    ("asked", "limit", "chosen"), [(None, 16, 8), (None, 4, 4), (16, 16, 16), (1, 16, 1), (99, 0, 99)]
)
def test_parallel_episodes_stay_within_the_servers_limit(asked: int | None, limit: int, chosen: int) -> None:
    assert run_settings.choose_parallel(pb.ServerInfo(max_episodes_per_stream=limit), asked) == chosen


def test_settings_not_offered_by_the_server_are_refused() -> None:
    with pytest.raises(UsageError, match="does not offer the encoding 'jpeg'; it offers raw, zstd"):
        run_settings.choose_encoding(INFO, "jpeg", "localhost:1")
    with pytest.raises(UsageError, match="does not offer images of 96 pixels; it offers 128, 224"):
        run_settings.choose_image_size(INFO, 96)
    with pytest.raises(UsageError, match="--parallel is 17, but the server allows at most 16 parallel episodes"):
        run_settings.choose_parallel(INFO, 17)
    assert (run_settings.choose_image_size(INFO, None), run_settings.choose_image_size(INFO, 128)) == (0, 128)
