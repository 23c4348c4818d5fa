"""Export of recorded runs as demonstrations."""

from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import minari
import pytest

from arramon_client.demonstrations import Demonstrations
from arramon_dataset.demonstrations.export import complete_request, export_demonstrations
from arramon_dataset.demonstrations.request import make_request
from arramon_dataset.demonstrations.sources import EpisodeActions, EpisodeSelection, ground_truth, recorded_run
from arramon_server.episodes.splits import read_named_split
from arramon_server.errors import ArraMonError, BadInput, Conflict
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from tests import played, tiny
from tests.dataset.demonstrations.exports import SIZE, expected_observations

CUT = {"1": tiny.ACTIONS[:5], "2": tiny.ACTIONS[:2], "4": (), "5": tiny.ACTIONS}
"""Actions of a run by episode: 5 is finished, the others were cut short."""


@pytest.fixture
def database(tmp_path: Path) -> Iterator[Database]:
    with closing(Database(f"sqlite:///{tmp_path / 'journal.db'}")) as database:
        yield database


def sources_of(database: Database, data: Path, run_id: str, language: str = "en") -> EpisodeSelection:
    split, journal = read_named_split(data, "tiny"), Journal(database)
    request = complete_request(make_request(data, "tiny", "plain", languages=(language,), run_id=run_id), split)
    return recorded_run(journal, journal.run(run_id), split, request)


def test_a_run_is_exported_as_it_was_played(data: Path, database: Database, tmp_path: Path) -> None:
    split = read_named_split(data, "tiny")
    ended = {"1": causes.TIME_LIMIT, "2": causes.FORFEITED, "4": causes.FORFEITED}
    played.play(database, split, actions=CUT, ended=ended)
    sources = sources_of(database, data, "r")
    assert {one.episode_id: (one.actions, one.cause) for one in sources.chosen} == {
        "1": (CUT["1"], causes.TIME_LIMIT),
        "2": (CUT["2"], causes.FORFEITED),
        "5": (CUT["5"], causes.AGENT_FINISHED),
    }
    assert sources.left_out == {"4": "nothing was played: it ended by FORFEITED"}
    assert sources.steps_per_phase == played.STEPS

    frames = make_request(data, "tiny", "minari", languages=("en",), run_id="r", sensors=("rgb",), size=SIZE)
    export_demonstrations(frames, split, sources, tmp_path / "minari", jobs=1, on_progress=lambda _: None)
    dataset = minari.MinariDataset(tmp_path / "minari" / "arramon" / "tiny-en-v0" / "data")
    order = [one.episode_id for one in sources.chosen]
    for number, episode_id in enumerate(order):
        episode = dataset[number]
        assert episode.actions.tolist() == list(CUT[episode_id])
        assert (bool(episode.terminations[-1]), bool(episode.truncations[-1])) == (
            (True, False) if episode_id == "5" else (False, True)
        )
        for step, expected in enumerate(expected_observations(data, episode_id, "en", CUT[episode_id])):
            assert (episode.observations["rgb"][step] == expected.rgb).all()
            assert episode.observations["steps_left"][step] == expected.steps_left - 150 + played.STEPS

    plain = replace(frames, format="plain", sensors=(), size=0)
    export_demonstrations(plain, split, sources, tmp_path / "plain", jobs=1, on_progress=lambda _: None)
    by_id = {one.episode_id: one for one in Demonstrations(tmp_path / "plain")}
    endings = {ending.episode_id: ending for ending in Journal(database).endings("r")}
    for episode_id in order:
        assert list(by_id[episode_id].scores.values()) == endings[episode_id].scores
        assert by_id[episode_id].finished == (episode_id == "5")


def test_runs_that_cannot_be_exported(data: Path, database: Database) -> None:
    split = read_named_split(data, "tiny")
    played.play(database, split, "over", {"1": tiny.ACTIONS})
    played.play(database, split, "open", {"1": tiny.ACTIONS[:3]}, over=False)
    with pytest.raises(Conflict, match="run 'open' is still being played; export it when it is over"):
        sources_of(database, data, "open")
    with pytest.raises(BadInput, match="run 'over' was played in 'en', not in hi"):
        sources_of(database, data, "over", "hi")
    changed = replace(split, data_hash="0" * 64)
    request = complete_request(make_request(data, "tiny", "plain", languages=("en",), run_id="over"), split)
    with pytest.raises(Conflict, match="which now has the data 000000000000"):
        recorded_run(Journal(database), Journal(database).run("over"), changed, request)


def test_ground_truth_that_no_run_could_play_is_left_out(data: Path) -> None:
    split = read_named_split(data, "tiny")
    episode = split.episodes["1"]
    long = replace(episode, turns=(replace(episode.turns[0], actions=(tiny.L,) * 151), episode.turns[1]))
    changed = replace(split, episodes={**split.episodes, "1": long})
    request = complete_request(make_request(data, "tiny", "plain"), split)
    found = ground_truth(changed, request)
    assert found.left_out == {"1": "its ground truth has a phase of more than 150 steps"}
    assert len(found.chosen) == 5


def test_a_sample_is_a_prefix(data: Path) -> None:
    split = read_named_split(data, "tiny")
    request = complete_request(make_request(data, "tiny", "plain"), split)
    some = ground_truth(split, replace(request, episodes=2)).chosen
    assert some == ground_truth(split, request).chosen[:2]
    assert {language for one in ground_truth(split, request).chosen for language in one.languages} == {"en", "hi"}


@pytest.mark.parametrize(
    ("actions", "said"),
    [
        (tiny.ACTIONS[:4], "its 4 actions do not end the episode"),
        ((*tiny.ACTIONS, 0), "after 13 of 14 actions: the episode is finished"),
    ],
)
@pytest.mark.parametrize("format_", ["plain", "huggingface"])
def test_actions_that_do_not_fit_are_named(
    data: Path, tmp_path: Path, actions: tuple[int, ...], said: str, format_: str
) -> None:
    split = read_named_split(data, "tiny")
    frames = {} if format_ == "plain" else {"sensors": ("rgb",), "size": 8}
    request = complete_request(make_request(data, "tiny", format_, **frames), split)  # type: ignore[arg-type]
    wrong = EpisodeSelection((EpisodeActions("1", ("en",), tuple(map(int, actions))),), {}, 150)
    with pytest.raises(ArraMonError, match="the actions for episode '1' do not fit its data") as caught:
        export_demonstrations(request, split, wrong, tmp_path / "out", jobs=1, on_progress=lambda _: None)
    assert said in str(caught.value)
