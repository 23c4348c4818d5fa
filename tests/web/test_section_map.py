"""Maps of sections from above, with the paths on them."""

from dataclasses import replace

from arramon_server.episodes.provenance import AGREEMENT, DRAWN, TEXT, PropOrigin
from arramon_server.scoring.trajectory import TurnRecord
from arramon_server.sim.section import Building, Prop, Section
from arramon_server.web.section_map import draw_section, turn_paths

SECTION = Section(
    "1",
    0.0,
    (-10.0, 0.0, 10.0, 30.0),
    (Building(0.0, 10.0, 2.0, 1.0, 90.0, 3.0, "brick"),),
    (Prop("cone", 1.0, 2.0, 0.0, "orange"),),
)


def test_ground_map_has_scaled_roofs_and_props() -> None:
    seen = draw_section(SECTION)
    assert (seen.width, seen.height) == (32.0, 42.0)
    assert seen.roofs == ("15,24 15,28 17,28 17,24",)
    assert seen.props == ((17.0, 34.0),)


def test_recovered_and_own_furniture_is_kept_apart_from_what_was_drawn() -> None:
    props = (*SECTION.props, Prop("bin", 0.0, 0.0, 0.0), Prop("bench", 2.0, 2.0, 0.0))
    origins = (PropOrigin(AGREEMENT, 23.6), PropOrigin(DRAWN), PropOrigin(TEXT))
    seen = draw_section(replace(SECTION, props=props), origins)
    assert (seen.agreed, seen.props, seen.from_text) == (((17.0, 34.0, 24),), ((16.0, 36.0),), ((18.0, 34.0),))


def test_tracks_show_played_paths_only_for_played_turns() -> None:
    record = TurnRecord(((0.0, 0.0), (0.0, 1.0)), (0.0, 0.1, 2.5), (2, 1, 2), path=((0.0, 0.0), (0.5, 0.0)))
    played = turn_paths(SECTION, record)
    assert (played.truth, played.played) == ("16,36 16,35", "16,36 16.5,36")
    assert (played.start, played.target, played.end) == ((16.0, 36.0), (16.0, 33.5), (16.5, 36.0))
    unplayed = turn_paths(SECTION, TurnRecord(((3.0, 0.0),), (0.0, 0.1, 2.5), (2, 1, 2)))
    assert (unplayed.played, unplayed.start, unplayed.end) == ("", (19.0, 36.0), None)
