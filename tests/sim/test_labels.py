"""The label table of segmentation images."""

import pytest

from arramon_server.sim.cameras import labels_of
from arramon_server.sim.catalogue import ALL_TYPES
from arramon_server.sim.labels import LABELS, SegmentationLabel, places_of
from arramon_server.sim.room_scene import room_scene


def test_labels_are_unique_and_start_with_nothing() -> None:
    assert len(set(LABELS)) == len(set(map(str, LABELS))) == len(LABELS)
    assert LABELS[0] == SegmentationLabel("nothing")


@pytest.mark.parametrize(
    ("label", "written"),
    [
        (SegmentationLabel("road"), "road"),
        (SegmentationLabel("cone", "red"), "cone/red"),
        (SegmentationLabel("building", look="brick"), "building//brick"),
        (SegmentationLabel("banner", "red", "star"), "banner/red/star"),
    ],
)
def test_labels_are_written_as_kind_colour_and_look(label: SegmentationLabel, written: str) -> None:
    assert str(label) == written
    assert label in LABELS


def test_camera_labels_map_to_table_indices() -> None:
    labels = labels_of(room_scene())
    told = [LABELS[place] for place in places_of(labels)]
    assert told[0] == SegmentationLabel("nothing")
    assert SegmentationLabel("wall", look="brick") in told
    assert told[-len(ALL_TYPES) :] == [SegmentationLabel.of(type_) for type_ in ALL_TYPES]


def test_unknown_label_is_an_error() -> None:
    with pytest.raises(KeyError):
        places_of(["a lake"])
