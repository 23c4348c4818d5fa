"""The official release, replayed in the simulator: every ground truth ends where the release says."""

import math
from contextlib import closing
from pathlib import Path

import pytest

from arramon_dataset.release.importer import import_release
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.worlds import Worlds
from arramon_server.scoring.trajectory import TurnRecord
from arramon_server.sim.rules import CollisionCheck, Limits
from tests.release import VAL_SEEN, needs_release

pytestmark = needs_release


@pytest.fixture(scope="module")
def split(tmp_path_factory: pytest.TempPathFactory) -> Split:
    folder: Path = tmp_path_factory.mktemp("data")
    return import_release([VAL_SEEN], folder)[0]


def replay(episode: Episode, ground: CollisionCheck) -> EpisodeSession:
    session = EpisodeSession(episode, ground, Limits())
    for turn in episode.turns:
        for action in (*turn.actions, *turn.room_actions):
            session.apply(action)
    return session


def check(turn: TurnRecord) -> float:
    """Asserts that a turn was played to the letter; returns how far its path strayed, in units."""
    assert turn.picked_target
    assert not turn.pickup_forced
    assert turn.placed_cell == turn.target_cell
    assert not turn.placement_forced
    assert len(turn.path) == len(turn.reference_path)
    return max(math.dist(one, other) for one, other in zip(turn.path, turn.reference_path, strict=True))


def test_all_episodes_are_imported(split: Split) -> None:
    assert len(split.episodes) == 1065
    assert sorted(split.sections) == ["1", "2", "3", "4", "5"]


@pytest.mark.parametrize("section", ["1", "2", "3", "4", "5"])
def test_every_ground_truth_replays_exactly(split: Split, section: str) -> None:
    with closing(Worlds({split.name: split})) as worlds:
        for episode in split.episodes.values():
            if episode.section == section:
                session = replay(episode, worlds.world(split.name, episode))
                assert session.state.finished
                for turn in session.record().turns:
                    assert check(turn) <= 0.001, f"episode {episode.episode_id}"


def test_distracters_and_decoys_satisfy_their_constraints(split: Split) -> None:
    for episode in split.episodes.values():
        for turn in episode.turns:
            target, *others = turn.street
            assert 4 <= len(others) <= 7
            for other in others:
                assert other.type != target.type
                shared = [
                    getattr(other.type, name) == getattr(target.type, name) for name in ("kind", "pattern", "colour")
                ]
                assert any(shared)
        assert len(episode.decoys) == 8
        on_floor = {(decoy.placement.column, decoy.placement.row) for decoy in episode.decoys}
        assert len(on_floor) == 8
        first, second = (turn.target_cell for turn in episode.turns)
        if first.level == 2:
            assert (first.column, first.row) in on_floor
        if second.level == 2:
            assert (second.column, second.row) in on_floor | {(first.column, first.row)}
