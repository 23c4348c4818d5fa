"""Numbers in docs/reference/agents.md, compared with the code."""

import numpy as np
import pytest

from arramon.v1 import types_pb2
from arramon_client import run_settings, world
from arramon_client.plugin import arguments
from arramon_client.recording import files, recorder
from arramon_client.transport.images import THOUSANDTHS, ImageDecoder
from arramon_client.world import SENSORS
from arramon_server.api.encoding import MessageEncoder
from arramon_server.configuration.config import Config
from arramon_server.episodes.splits import Split
from arramon_server.sim import cameras, room, rules
from arramon_server.sim.view import view
from tests import ROOT, tiny

PAGE = (ROOT / "docs" / "reference" / "agents.md").read_text()
CONFIG = Config()
LARGEST = 65535 * float(THOUSANDTHS)

HIDDEN = Split("secret", hidden=True, source="", data_hash="", episodes={}, sections={})


def _quoted(names: tuple[str, ...]) -> str:
    return "(" + ", ".join(f'"{name}"' for name in names) + ")"


SENTENCES = [
    "| `rgb` | (size, size, 3) uint8, 0 to 255 |",
    f"in steps of {float(THOUSANDTHS):.3f} |",
    f"| `depth`, largest | {LARGEST:.3f}: that far and beyond; nothing beyond {cameras.FAR:g} units is drawn |",
    f"| size | {CONFIG.image_sizes[0]} (default) or {CONFIG.image_sizes[1]}, or",
    f"| field of view | {world.FIELD_OF_VIEW:g} degrees,",
    f"| eye height | {world.EYE_HEIGHT:g} units, in the street and in the room |",
    f"| forward, {world.Action.FORWARD:d} | {world.STEP:g} unit ahead,",
    f"| left, {world.Action.LEFT:d}; right, {world.Action.RIGHT:d} | {world.TURN:g} degrees |",
    f"| pick up / place, {world.Action.INTERACT:d} |",
    f"one cell ahead ({world.CELL_SIZE:g} units)",
    f"| {world.TURN:g} degrees | {world.TURN:g} degrees |",
    f"up to {world.REACH_AHEAD + world.REACH_MARGIN:g} units ahead and {world.REACH_SIDE + world.REACH_MARGIN:g} to",
    f"a disc of radius {world.AGENT_RADIUS:g} units",
    f"The room has {world.COLUMNS} columns and {world.ROWS} rows; "
    f"every assembly begins at column {room.START.column},\n"
    f"row {room.START.row}, heading 0",
    f"A phase takes {world.STEPS_PER_PHASE} steps at most",
    f"`--parallel` ({run_settings.DEFAULT_PARALLEL} by default; "
    f"a server allows up to {CONFIG.max_episodes_per_stream} on",
    f"due {CONFIG.step_seconds:g} seconds after",
    f"the run's bank of {CONFIG.bank_seconds:g} seconds, a day",
    f"There can be {arguments.MOST_ARGUMENTS}, with names of up to {arguments.LONGEST_NAME} characters, "
    f"values of up to\n{arguments.LONGEST_VALUE} and {arguments.LONGEST_IN_ALL} in all",
    f"JPEG of quality {files.JPEG_QUALITY};",
    f"where {recorder.MAX_QUEUED_BYTES // 2**20} MiB of pictures wait",
    f"names what it needs, `{_quoted(world.DEFAULT_SENSORS)}` by default",
    f"A hidden split offers\n`{'` and `'.join(HIDDEN.sensors)}` alone",
    f"others `{SENSORS[2]}`, `{SENSORS[3]}` and `{SENSORS[4]}` (ground truth",
    "With t = 5 seconds, `--parallel 6` is the most that\nfits 60 seconds",
]


@pytest.mark.parametrize("sentence", SENTENCES)
def test_numbers_on_the_page_match_the_code(sentence: str) -> None:
    assert " ".join(sentence.split()) in " ".join(PAGE.split())  # independent of line breaks


def test_clock_example_on_the_page_fits_the_step_time() -> None:
    assert 2 * 6 * 5 <= CONFIG.step_seconds < 2 * 7 * 5


def test_camera_height_is_equal_in_street_and_room() -> None:
    layout = tiny.episode("a").layout
    street = rules.begin(layout)
    for phase in rules.Phase:
        state = rules.State(street.pose, street.room, phase=phase)
        assert view(state, layout).viewpoint.z == world.EYE_HEIGHT


@pytest.mark.parametrize("encoding", [types_pb2.ENCODING_RAW, types_pb2.ENCODING_ZSTD, types_pb2.ENCODING_JPEG])
def test_arrays_are_read_only_and_have_the_ranges_on_the_page(encoding: types_pb2.Encoding.ValueType) -> None:
    encoder = MessageEncoder(encoding)
    rgb, numbers = types_pb2.Image(), types_pb2.Image()
    images = (np.full((16, 16, 3), 255, np.uint8), rgb), (np.array([[0, 1, 65535]], np.uint16), numbers)
    for (_, image), data in zip(images, encoder.encode("", images, latest=True), strict=True):
        image.data = bytes(data)
    colours, depth, places = (
        ImageDecoder().rgb(rgb),
        ImageDecoder().depth(numbers),
        ImageDecoder().segmentation(numbers),
    )
    assert colours.max() == 255
    assert depth[0].tolist() == pytest.approx([0.0, 0.001, LARGEST])
    for array in (colours, depth, places):
        assert not array.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1
