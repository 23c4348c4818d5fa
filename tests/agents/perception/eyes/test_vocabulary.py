"""The encoder's vocabulary covers the simulator's labels."""

import pytest

from arramon_agents.perception.eyes.vocabulary import COLOURED, KINDS, LOOK_GROUPS, LOOKS, NONE, codes_of
from arramon_client.world import COLLECTIBLES, FACADES, FURNITURE
from arramon_client.world import COLLECTIBLES as CATALOGUE
from arramon_server.sim.assets.furniture import COLOURS
from arramon_server.sim.labels import LABELS


def test_every_label_of_the_simulator_has_codes_of_its_own() -> None:
    codes = [codes_of(label.kind, label.colour, label.look) for label in LABELS]
    assert len(set(codes)) == len(LABELS)
    assert {KINDS[code.kind] for code in codes} == set(KINDS)
    assert {code.look for code in codes} == {NONE, *range(len(LOOKS))}


def test_names_are_the_simulators() -> None:
    assert COLLECTIBLES == CATALOGUE
    assert FURNITURE == FURNITURE
    assert set(COLOURED) == set(COLOURS)
    assert {group.name: group.looks for group in LOOK_GROUPS}["facade"] == FACADES


@pytest.mark.parametrize(
    ("label", "problem"),
    [
        (("unicorn", "", ""), "not in tuple"),
        (("mug", "pink", ""), "not in tuple"),
        (("bench", "", "dotted"), "no look"),
    ],
)
def test_unknown_names_are_refused(label: tuple[str, str, str], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        codes_of(*label)
