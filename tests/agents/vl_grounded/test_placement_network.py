"""Assembly phase: look around, network inputs, and the path to the target cell."""

import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from arramon_agents.mapping.probabilistic_room_memory import ProbabilisticRoomMemory  # noqa: E402
from arramon_agents.perception.eyes.predicted_segmentation import LABELS  # noqa: E402
from arramon_agents.vl_grounded.assembly_player import AssemblyPlayer  # noqa: E402
from arramon_agents.vl_grounded.attributes import KINDS  # noqa: E402
from arramon_agents.vl_grounded.look_around import TURNS, LookAround, attributes_in_rooms  # noqa: E402
from arramon_agents.vl_grounded.network import Grounded  # noqa: E402
from arramon_agents.vl_grounded.placement_network import CELLS, LEVELS  # noqa: E402
from arramon_lang.cell_grading import RoomObject  # noqa: E402


def test_a_look_around_shows_each_heading_once() -> None:
    look, headings = LookAround(ProbabilisticRoomMemory(LABELS)), []
    while True:
        if look.is_new():
            headings.append(look.heading)
        if look.turn() is None:
            break
    assert headings == [0, -30, -60, -90, 30, 60, 90]


def test_things_by_cell_and_level() -> None:
    things = (RoomObject("mug", "red", "dotted", 1, 2, 1), RoomObject("tv", "blue", "striped", 1, 2, 2))
    there = attributes_in_rooms([things, ()])
    assert there.kinds.shape == (2, CELLS * LEVELS, len(KINDS))
    filled = [divmod(place, LEVELS) for place in there.kinds[0, :, 0].nonzero()[:, 0].tolist()]
    assert filled == [(2 * 5 + 1, 0), (2 * 5 + 1, 1)]
    assert there.kinds[1].sum() == 0


@pytest.mark.parametrize(
    ("steps_left", "cell", "expected"),
    [
        (150, 2 + 5 * 1, [*TURNS, *[1] * 3, 3]),  # Straight ahead of the start tile, after the look around.
        (20, 2 + 5 * 1, [3]),  # Without time to look.
        (20, 3, [2, 2, 2, 3]),
        (20, 2 + 5 * 2, [0, 3]),
    ],
)
def test_the_way(steps_left: int, cell: int, expected: list[int]) -> None:
    torch.manual_seed(1)
    network = Grounded(9).eval()
    with torch.no_grad():
        network.room.anywhere.bias[cell] = 100.0
    placer = AssemblyPlayer(network, torch.tensor([[2, 3]]), LookAround(ProbabilisticRoomMemory(LABELS)))
    actions: list[int] = []
    while not actions or actions[-1] != 3:
        actions.append(placer.act(steps_left - len(actions)))
    assert actions == expected
