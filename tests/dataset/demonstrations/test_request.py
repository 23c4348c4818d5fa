"""Invalid export requests: each error names what was wrong and what was expected."""

from pathlib import Path
from typing import Any

import pytest

from arramon_dataset.demonstrations.export import complete_request
from arramon_dataset.demonstrations.request import make_request
from arramon_server.episodes.splits import read_named_split
from arramon_server.errors import BadInput, Forbidden, NotFound


@pytest.mark.parametrize(
    ("format_", "more", "said"),
    [
        ("zip", {}, "there is no format 'zip'; there are minari, lerobot, huggingface, plain"),
        ("minari", {"sensors": ("lidar",)}, "there is no sensor 'lidar' to export; there are rgb, depth, segmentation"),
        ("minari", {"sensors": ("oracle",)}, "there is no sensor 'oracle' to export"),
        ("minari", {"sensors": ()}, "no sensor was named; there are rgb"),
        ("minari", {"size": 100}, "the size is 100; expected a multiple of 8 from 8 to 448, or 84"),
        ("minari", {"size": 456}, "the size is 456; expected"),
        ("minari", {"size": 0}, "the size is 0; expected"),
        ("minari", {"reward": "gold"}, "there is no reward 'gold'; there are sparse, progress, none"),
        ("minari", {"episodes": 0}, "the number of episodes is 0; expected at least 1"),
        ("minari", {"part_size": 0}, "the number of episodes in a part is 0"),
        ("plain", {"single_dataset": True}, "--single-dataset applies to the format 'minari' only"),
        ("plain", {"size": 64}, "the format 'plain' holds no frames"),
        ("plain", {"sensors": ("rgb",)}, "it takes neither sensors nor a size"),
    ],
)
def test_settings_that_are_wrong_in_themselves(format_: str, more: dict[str, Any], said: str) -> None:
    with pytest.raises(BadInput) as caught:
        make_request(Path("data"), "tiny", format_, **more)
    assert said in str(caught.value)


@pytest.mark.parametrize("size", [8, 84, 224, 448])
def test_sizes_of_the_environments(size: int) -> None:
    assert make_request(Path("data"), "tiny", "minari", size=size).size == size


def test_order_and_repetition_of_names_do_not_matter() -> None:
    one = make_request(Path("data"), "tiny", "minari", sensors=("pose", "rgb"), languages=("hi", "en", "hi"))
    assert one == make_request(Path("data"), "tiny", "minari", sensors=("rgb", "pose"), languages=("en", "hi"))


def test_settings_that_the_split_does_not_have(data: Path) -> None:
    with pytest.raises(NotFound, match=r"there is no split 'nowhere' in .*; there are secret, tiny"):
        read_named_split(data, "nowhere")
    with pytest.raises(BadInput, match="the split 'tiny' has no language 'fr'; it has en, hi"):
        complete_request(make_request(data, "tiny", "plain", languages=("fr",)), read_named_split(data, "tiny"))


@pytest.mark.parametrize("format_", ["plain", "minari", "lerobot", "huggingface"])
def test_hidden_splits_are_refused(data: Path, format_: str) -> None:
    with pytest.raises(Forbidden, match=r"the split 'secret' is hidden: .* from open splits only"):
        complete_request(make_request(data, "secret", format_), read_named_split(data, "secret"))
