"""An episode's own furniture: what it may hold, and the section as it is in the episode."""

import pytest

from arramon_server.sim.own_furniture import MovedProp, OwnFurniture, furnished
from arramon_server.sim.section import Prop, Section

PROPS = (
    Prop("cone", 1.0, 1.0, 0.0, "orange"),
    Prop("bench", 2.0, 1.0, 90.0),
    Prop("zebra_crossing", 3.0, 1.0, 0.0),
    Prop("banner", 4.0, 1.0, 0.0, "red", "star", "white"),
)
SECTION = Section("1", 0.0, (0.0, 0.0, 9.0, 9.0), (), PROPS)
BIN = Prop("bin", 5.0, 5.0, 0.0)


def test_section_in_an_episode() -> None:
    own = OwnFurniture(added=(BIN,), moved=(MovedProp(1, 7.0, 8.0, 45.0),), left_out=(0,))
    assert furnished(SECTION, own).props == (Prop("bench", 7.0, 8.0, 45.0), PROPS[2], PROPS[3], BIN)
    assert not own.is_empty


def test_without_own_furniture_the_section_is_the_same() -> None:
    assert OwnFurniture().is_empty
    assert furnished(SECTION, OwnFurniture()) is SECTION


@pytest.mark.parametrize(
    "prop",
    [
        Prop("bin", 0.0, 0.0, 0.0),
        Prop("cone", 0.0, 0.0, 0.0),
        Prop("cone", 0.0, 0.0, 0.0, "blue"),
        Prop("banner", 0.0, 0.0, 0.0, "black", "dot", "orange"),
        Prop("shop_sign", 0.0, 0.0, 0.0, shape="hotel"),
    ],
)
def test_props_that_an_episode_may_have(prop: Prop) -> None:
    assert OwnFurniture(added=(prop,)).added == (prop,)


@pytest.mark.parametrize(
    ("prop", "what"),
    [
        (Prop("cat", 0.0, 0.0, 0.0), "there is no furniture such as a 'cat'"),
        (Prop("cone", 0.0, 0.0, 0.0, "gold"), "there is no furniture such as a 'gold cone'"),
        (Prop("bin", 0.0, 0.0, 0.0, "red"), "there is no furniture such as a 'red bin'"),
        (Prop("banner", 0.0, 0.0, 0.0, "red", "star", ""), "there is no furniture such as a 'red star banner'"),
        (Prop("banner", 0.0, 0.0, 0.0, "red", "moon", "white"), "such as a 'red white moon banner'"),
        (Prop("zebra_crossing", 0.0, 0.0, 0.0), "a zebra_crossing cannot be an episode's own"),
    ],
)
def test_props_that_do_not_exist(prop: Prop, what: str) -> None:
    with pytest.raises(ValueError, match=what):
        OwnFurniture(added=(prop,))


def test_a_prop_is_changed_once() -> None:
    with pytest.raises(ValueError, match="prop 1 is moved or left out twice"):
        OwnFurniture(moved=(MovedProp(1, 0.0, 0.0, 0.0),), left_out=(1,))


@pytest.mark.parametrize(
    ("own", "what"),
    [
        (OwnFurniture(left_out=(4,)), "names prop 4 of section '1', which has 4"),
        (OwnFurniture(left_out=(-1,)), "names prop -1 of section '1', which has 4"),
        (OwnFurniture(moved=(MovedProp(2, 0.0, 0.0, 0.0),)), "changes prop 2 of section '1', a zebra_crossing"),
    ],
)
def test_the_section_must_have_what_is_changed(own: OwnFurniture, what: str) -> None:
    with pytest.raises(ValueError, match=what):
        own.check(SECTION)
