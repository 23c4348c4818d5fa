"""Void episodes and corrected data: scores, ranks and receipts follow, for all runs alike."""

import csv
import io
import json
import shutil
from contextlib import closing
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from arramon_server.board.board import Board
from arramon_server.board.corrector import Corrector, RescoredRun
from arramon_server.board.exports import as_csv
from arramon_server.board.publisher import Publisher
from arramon_server.board.standings import BOTH, Mark, Standing
from arramon_server.episodes.episode import Episode, Instructions
from arramon_server.episodes.splits import read_split, write_split
from arramon_server.errors import BadInput, Conflict, NotFound
from arramon_server.runs.accounts.callers import HOST, READER
from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.results.receipts import Receipts, stored_receipt
from arramon_server.runs.results.reports import report_of
from arramon_server.runs.results.rescoring import Rescorer
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.records import CANCELLED, CodeReference
from arramon_server.sim.geometry import Pose
from arramon_server.sim.room import RoomPosition
from arramon_server.sim.section import Building, Section
from tests import tiny
from tests.board.leaderboard_backend import LeaderboardBackend
from tests.played import STEPS, play

FAILING = (0, 0, 3, 0, 0, 3)
"""Picks the first target up and puts it one cell too far; the rest is forfeited."""


class Host:
    """A journal with three published runs on the split "tiny": `good` and `twin` solve all, `poor` fails in episode 0.

    Attributes:
        splits: the splits as the host has them now.
    """

    def __init__(self, folder: Path, backend: LeaderboardBackend) -> None:
        self.folder, self.backend = folder, backend
        self.key = SigningKey(folder / "key.pem")
        self.splits = {"tiny": backend.splits["tiny"]}
        self.before = backend.splits["tiny"]
        for run_id in ("good", "twin", "poor"):
            actions: dict[str, tuple[int, ...]] = dict.fromkeys(self.before.episodes, tiny.ACTIONS)
            if run_id == "poor":
                actions["0"] = FAILING
            play(backend.database, self.before, run_id, actions, ended={"0": "FORFEITED"})
            Publisher(backend.journal, self.splits, backend.entries, self.receipts).publish(HOST, run_id, "")

    @property
    def receipts(self) -> Receipts:
        return Receipts(self.backend.database, self.splits, self.key)

    @property
    def corrector(self) -> Corrector:
        return Corrector(self.backend.database, self.splits, self.key)

    def board(self) -> Board:
        return Board(self.backend.entries, self.splits, steps_per_phase=STEPS, clocks=ClockSettings())

    def standings(self, board: Board | None = None) -> dict[str, Standing]:
        found = (board or self.board()).standings("tiny", "en")
        return {one.entries[0].run.run_id: one for one in found}

    def replace(self, *, hidden: bool = False, **changed: Episode) -> None:
        """Correct the data: write the split again with other episodes, given by `e` and id."""
        episodes = [changed.get(f"e{name}", one) for name, one in self.before.episodes.items()]
        self.write(episodes, hidden=hidden)

    def write(self, episodes: list[Episode], *, hidden: bool = False, section: Section = tiny.SECTION) -> None:
        old = self.folder / "old" / "tiny"
        if not old.exists():
            old.parent.mkdir()
            (self.folder / "splits" / "tiny").rename(old)
        self.before = read_split(old)
        self.splits["tiny"] = write_split(
            self.folder,
            "tiny",
            hidden=hidden,
            source="tests",
            episodes=episodes,
            sections=[section],
        )

    def rescore(self, reason: str = "the cell was wrong") -> dict[str, RescoredRun]:
        return {one.run.run_id: one for one in self.corrector.rescore(self.before, reason)}

    def content(self, run_id: str, number: int = 0) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self.receipts.of(READER, run_id, number).payload)
        return found


@pytest.fixture
def host(backend: LeaderboardBackend, tmp_path: Path) -> Host:
    return Host(tmp_path, backend)


def ptc(standing: Standing) -> float:
    return standing.rows["total"]["PTC"].mean


def moved_cell(episode: Episode) -> Episode:
    """The first turn's target belongs where `FAILING` puts it."""
    first, second = episode.turns
    return replace(episode, turns=(replace(first, target_cell=RoomPosition(2, 1, 3)), second))


def test_a_void_episode_counts_in_no_run(host: Host) -> None:
    board = host.board()
    before = host.standings(board)
    assert ptc(before["good"]) == 1.0
    assert ptc(before["poor"]) == pytest.approx(10 / 12)
    host.corrector.void("tiny", ["0"], "its target is not there")
    after = host.standings(board)  # the board of a server that runs
    assert [ptc(after[name]) for name in ("good", "twin", "poor")] == [1.0, 1.0, 1.0]
    assert {one.is_ranked for one in after.values()} == {True}
    assert {one.entries[0].voided for one in after.values()} == {1}
    assert "|episodes:5|" in after["poor"].entries[0].signature
    assert "|void:" in after["poor"].entries[0].signature
    (found,) = board.corrections("tiny")
    assert (found.kind.value, found.reason, found.episodes) == ("void", "its target is not there", ("0",))
    assert board.entry("poor").corrections == (found,)
    (line, _) = board.compare_with_all("good").lines
    assert line[1].difference.mean == 0.0


def test_a_restored_episode_counts_again(host: Host) -> None:
    board = host.board()
    before = host.standings(board)
    host.corrector.void("tiny", ["0", "1"], "doubtful")
    host.corrector.void("tiny", ["0"], "it was right", restore=True)
    assert host.corrector.void("tiny", ["1"], "it, too", restore=True).number == 3
    after = host.standings(board)
    assert {name: (one.rows, one.entries[0].signature) for name, one in after.items()} == {
        name: (one.rows, one.entries[0].signature) for name, one in before.items()
    }


def test_receipts_of_void_episodes_are_superseded_and_kept(host: Host) -> None:
    first = stored_receipt(host.backend.database, "poor")
    assert first is not None
    host.corrector.void("tiny", ["0"], "its target is not there")
    assert host.corrector.renew_receipts("tiny") == 3
    assert host.corrector.renew_receipts("tiny") == 0
    content = host.content("poor")
    assert content["voided"] == ["0"]
    assert content["scores"]["total"]["PTC"]["mean"] == 1.0
    assert "|episodes:5|" in str(content["score_signature"])
    revision, (correction,) = content["revision"], content["corrections"]
    assert (revision["number"], revision["supersedes"]) == (1, sha256(first.payload).hexdigest())
    assert {name: correction[name] for name in ("kind", "reason", "episodes")} == {
        "kind": "void", "reason": "its target is not there", "episodes": ["0"],
    }  # fmt: skip
    assert content["attempts"] == json.loads(first.payload)["attempts"]
    assert "scores" not in content["episodes"][[e["episode_id"] for e in content["episodes"]].index("0")]
    assert host.receipts.of(READER, "poor", 1) == first
    with pytest.raises(NotFound, match="no superseded receipt 2"):
        host.receipts.of(READER, "poor", 2)
    fingerprint = host.board().entry("poor").receipt_fingerprint
    assert fingerprint is not None
    assert [(one.number, one.digest) for one in fingerprint.superseded] == [(1, sha256(first.payload).digest())]
    with closing(Rescorer(host.backend.database, host.splits)) as rescorer:
        assert rescorer.rescore("poor").differences == ()


def test_a_receipt_is_superseded_when_it_is_asked_for_at_the_latest(host: Host) -> None:
    host.corrector.void("tiny", ["0"], "killed before the receipts")
    assert host.content("good")["voided"] == ["0"]


def test_the_first_receipt_after_a_correction_names_it(host: Host) -> None:
    host.corrector.void("tiny", ["0"], "doubtful")
    play(host.backend.database, host.before, "late")
    content = json.loads(host.receipts.of(HOST, "late").payload)
    assert content["voided"] == ["0"]
    assert [one["reason"] for one in content["corrections"]] == ["doubtful"]
    assert "revision" not in content


def test_a_run_that_did_not_play_a_void_episode_is_left_alone(host: Host) -> None:
    play(host.backend.database, host.before, "part", {"1": tiny.ACTIONS})
    publisher = Publisher(host.backend.journal, host.splits, host.backend.entries, host.receipts)
    publisher.publish(HOST, "part", "")
    kept = stored_receipt(host.backend.database, "part")
    host.corrector.void("tiny", ["0"], "doubtful")
    assert host.corrector.renew_receipts("tiny") == 3
    assert stored_receipt(host.backend.database, "part") == kept
    assert host.board().entry("part").corrections == ()
    host.corrector.void("tiny", ["1"], "doubtful")  # all that the run has
    entry = host.board().entry("part")
    assert (entry.voided, ptc(host.standings()["part"])) == (1, 1.0)
    assert Mark.PARTIAL in entry.marks
    assert stored_receipt(host.backend.database, "part") == kept


@pytest.mark.parametrize("in_hindi", [1, 4], ids=["all void", "void in English alone"])
def test_a_system_of_void_episodes_alone_keeps_its_scores_over_languages(
    backend: LeaderboardBackend, tmp_path: Path, in_hindi: int
) -> None:
    first = {language: backend.splits["tiny"].in_playing_order(language)[0].episode_id for language in ("en", "hi")}
    backend.publish(backend.run("english", [0.5]))
    backend.publish(backend.run("hindi", [1.0] * in_hindi, language="hi"))
    void = {first["en"], first["hi"]} if in_hindi == 1 else {first["en"]}
    Corrector(backend.database, backend.splits, SigningKey(tmp_path / "key.pem")).void("tiny", void, "doubtful")
    (line,) = backend.board.combined_standings("tiny")
    assert line.entries[0].voided == 1
    assert ptc(line) == pytest.approx(0.75)
    assert not line.is_ranked
    (row,) = csv.DictReader(io.StringIO(as_csv(backend.board.listing("tiny", BOTH))))
    assert float(row["PTC@CTC-3"]) == pytest.approx(0.75)


def test_a_reproduction_of_void_episodes_alone_keeps_its_difference(
    backend: LeaderboardBackend, tmp_path: Path
) -> None:
    backend.participant("ann", "bob")
    for account, score in (("ann", 0.5), ("bob", 0.75)):
        backend.run(
            account, [score], account=account, participant=account, code=CodeReference("https://example.org/walker")
        )
    backend.publish("ann")
    backend.publisher.publish(HOST, "bob", "", reproduces="ann")
    (episode,) = backend.entries.all_episode_scores("ann").ids
    Corrector(backend.database, backend.splits, SigningKey(tmp_path / "key.pem")).void("tiny", [episode], "doubtful")
    (found,) = backend.board.reproductions("ann")
    assert found.differences["PTC@CTC-3"].mean == pytest.approx(0.25)


@pytest.mark.parametrize(("episodes", "restore", "reason", "error", "message"), [
    (["9"], False, "x", NotFound, "split 'tiny' has no episode '9'"),
    (["0"], True, "x", Conflict, r"1 episode \('0'\) of split 'tiny' not void"),
    (["1"], False, "x", Conflict, "void already"),
    (["0", "2", "3", "4", "5"], False, "x", Conflict, "would be left"),
    (["2", "4", "5"], False, "x", Conflict, "no episode of split 'tiny' would be left in a language"),
    (["0"], False, " ", BadInput, "expected one line of 1 to 500"),
    (["0"], False, "a\nb", BadInput, "expected one line of visible characters"),
])  # fmt: skip
def test_what_cannot_be_voided(
    host: Host, episodes: list[str], restore: bool, reason: str, error: type[Exception], message: str
) -> None:
    host.corrector.void("tiny", ["1"], "doubtful")
    with pytest.raises(error, match=message):
        host.corrector.void("tiny", episodes, reason, restore=restore)
    assert len(host.board().corrections("tiny")) == 1


def test_runs_are_scored_again_on_a_corrected_ground_truth_and_stay_ranked(host: Host) -> None:
    first = stored_receipt(host.backend.database, "poor")
    assert first is not None
    assert ptc(host.standings()["poor"]) == pytest.approx(10 / 12)
    old = host.before.data_hash
    host.replace(e0=moved_cell(host.before.episodes["0"]))
    assert {one.marks for one in host.standings().values()} == {(Mark.OTHER_DATA,)}
    found = host.rescore()
    assert {name: (one.problem, one.changed, one.has_new_receipt) for name, one in found.items()} == dict.fromkeys(
        ("good", "twin", "poor"), ("", 1, True)
    )
    after = host.standings()
    assert {one.marks for one in after.values()} == {()}
    assert all(one.rank for one in after.values())
    assert ptc(after["poor"]) == pytest.approx(11 / 12)
    assert ptc(after["good"]) == pytest.approx(11 / 12)
    content = host.content("poor")
    new = host.splits["tiny"].data_hash
    assert content["data_hash"] == new
    assert content["scores"]["total"]["PTC"]["mean"] == pytest.approx(11 / 12)
    (correction,) = content["corrections"]
    assert correction == {
        "kind": "rescore", "reason": "the cell was wrong", "episodes": ["0"], "data_before": old, "data_after": new,
        "made_at": correction["made_at"],
    }  # fmt: skip
    assert host.receipts.of(READER, "poor", 1) == first
    with closing(Rescorer(host.backend.database, host.splits)) as rescorer:
        for run_id in ("good", "twin", "poor"):
            assert rescorer.rescore(run_id).differences == ()
    assert host.rescore() == {}


def test_a_server_that_runs_shows_the_new_scores_once_it_has_the_new_data(host: Host) -> None:
    host.replace(e0=moved_cell(host.before.episodes["0"]))
    board = host.board()
    host.standings(board)
    host.rescore()
    assert ptc(host.standings(board)["poor"]) == pytest.approx(11 / 12)


def test_runs_on_a_hidden_split_are_scored_again_with_fresh_thresholds(
    backend: LeaderboardBackend, tmp_path: Path
) -> None:
    shutil.rmtree(tmp_path / "splits" / "tiny")
    backend.splits["tiny"] = tiny.write(tmp_path, count=24, hidden=True)
    host = Host(tmp_path, backend)
    board = host.board()
    host.standings(board)
    old = host.content("poor")
    host.corrector.void("tiny", ["1"], "a wall in the way")
    host.content("poor")
    host.replace(e0=moved_cell(host.before.episodes["0"]), hidden=True)
    assert {name: one.problem for name, one in host.rescore().items()} == dict.fromkeys(("good", "twin", "poor"), "")
    content = host.content("poor")
    assert [one["version"] for one in (old, content)] == [2, 2]
    assert content["data_hash"] == host.splits["tiny"].data_hash != old["data_hash"]
    assert (content["voided"], content["revision"]["number"]) == (["1"], 2)
    assert [one["kind"] for one in content["corrections"]] == ["void", "rescore"]
    board._splits = host.splits
    after = host.standings(board)
    assert {one.is_ranked for one in after.values()} == {True}
    for name in ("good", "poor"):
        run = backend.journal.run(name)
        assert after[name].rows == report_of(run, backend.journal, host.splits).table.rows
    with closing(Rescorer(backend.database, host.splits)) as rescorer:
        assert rescorer.rescore("poor").differences == ()


def test_an_interrupted_rescoring_goes_on(host: Host) -> None:
    host.replace(e0=moved_cell(host.before.episodes["0"]))
    going = host.corrector.rescore(host.before, "the cell was wrong")
    next(going)
    going.close()  # type: ignore[attr-defined]  # a generator
    assert len([one for one in host.standings().values() if one.rank]) == 1
    assert len(host.rescore("another word")) == 2
    assert [one.reason for one in host.board().corrections("tiny")] == ["the cell was wrong"]
    assert all(one.rank for one in host.standings().values())


def test_data_that_was_adopted_and_reverted_is_adopted_again(host: Host) -> None:
    moved = moved_cell(host.before.episodes["0"])
    host.replace(e0=moved)
    host.rescore("the cell was wrong")
    wrong = host.splits["tiny"]
    host.write([*host.before.episodes.values()])
    assert {one.problem for one in host.corrector.rescore(wrong, "it was right")} == {""}
    assert ptc(host.standings()["poor"]) == pytest.approx(10 / 12)
    host.replace(e0=moved)
    assert {one.problem for one in host.rescore("it was wrong after all").values()} == {""}
    assert ptc(host.standings()["poor"]) == pytest.approx(11 / 12)
    reasons = ["the cell was wrong", "it was right", "it was wrong after all"]
    assert [one.reason for one in host.board().corrections("tiny")] == reasons
    content = host.content("poor")
    assert [one["reason"] for one in content["corrections"]] == reasons
    assert content["revision"]["number"] == 3
    with closing(Rescorer(host.backend.database, host.splits)) as rescorer:
        assert rescorer.rescore("poor").differences == ()


def test_a_changed_text_leaves_the_scores_and_is_named(host: Host) -> None:
    text = Instructions("Go on to the mug with red stripes.", "Put it two steps ahead.")
    old = host.before.episodes["0"]
    host.replace(e0=replace(old, instructions={**old.instructions, "en": (text, text)}))
    before = {name: one.rows for name, one in host.standings().items()}
    assert {one.changed for one in host.rescore("a typing error").values()} == {0}
    after = host.standings()
    assert {name: one.rows for name, one in after.items()} == before
    assert all(one.rank for one in after.values())
    assert host.content("good")["corrections"][0]["episodes"] == ["0"]


def test_another_object_as_target_is_scored_again(host: Host) -> None:
    first, second = host.before.episodes["0"].turns
    swapped = replace(first, street=(first.street[1], first.street[0]))
    host.replace(e0=replace(host.before.episodes["0"], turns=(swapped, second)))
    assert {one.problem for one in host.rescore("the other mug was meant").values()} == {""}
    assert host.standings()["good"].rows["turn 1"]["CTC-0"].mean == pytest.approx(5 / 6)


def test_equally_near_objects_are_told_apart_by_a_replay(host: Host) -> None:
    first, second = host.before.episodes["0"].turns
    near = replace(first.street[1], position=first.street[0].position)
    host.write([
        replace(one, turns=(replace(first, street=(first.street[0], near)), second)) if name == "0" else one
        for name, one in host.before.episodes.items()
    ])  # fmt: skip
    twins = host.splits["tiny"]
    play(host.backend.database, twins, "between")
    host.write([
        replace(one, turns=(replace(first, street=(near, first.street[0])), second)) if name == "0" else one
        for name, one in host.before.episodes.items()
    ])  # fmt: skip
    (found,) = host.corrector.rescore(twins, "the other one")
    assert found.problem == "it cannot be replayed: episode 0: the agent would have picked up another object"
    assert host.backend.journal.run("between").data_hash == twins.data_hash


WORLDS = {
    "start": lambda one: replace(one, start=Pose(0.0, 0.0, 30.0)),
    "decoys": lambda one: replace(one, decoys=()),
    "street": lambda one: replace(one, turns=(one.turns[0], replace(one.turns[1], street=one.turns[1].street[:1]))),
}


@pytest.mark.parametrize("part", WORLDS)
def test_a_changed_world_is_refused_until_the_episode_is_void(host: Host, part: str) -> None:
    changed = {"e0": WORLDS[part](host.before.episodes["0"]), "e1": moved_cell(host.before.episodes["1"])}
    host.replace(**changed)
    with pytest.raises(Conflict, match=r"the world of 1 episode \('0'\) of split 'tiny' has changed"):
        host.rescore()
    assert {one.marks for one in host.standings().values()} == {(Mark.OTHER_DATA,)}
    assert host.board().corrections("tiny") == ()
    host.corrector.void("tiny", ["0"], "its world was wrong")
    assert {one.problem for one in host.rescore().values()} == {""}
    after = host.standings()
    assert all(one.rank for one in after.values())
    assert ptc(after["poor"]) == pytest.approx(9 / 10)
    with closing(Rescorer(host.backend.database, host.splits)) as rescorer:
        assert rescorer.rescore("poor").differences == ()
    assert [one["kind"] for one in host.content("poor")["corrections"]] == ["void", "rescore"]


def test_a_changed_section_is_refused(host: Host) -> None:
    section = replace(tiny.SECTION, buildings=(Building(0.0, 12.0, 6.0, 1.0, 0.0, 3.0, "brick"),))
    host.write(list(host.before.episodes.values()), section=section)
    with pytest.raises(Conflict, match=r"the world of 6 episodes \('0', '1', '2', '3', '4', ...\)"):
        host.rescore()


def test_other_episodes_or_languages_are_refused(host: Host) -> None:
    episodes = list(host.before.episodes.values())
    host.write(episodes[1:])
    with pytest.raises(Conflict, match=r"1 episode \('0'\) left out, no episode added"):
        host.rescore()
    host.write([replace(episodes[0], instructions={**episodes[1].instructions}), *episodes[1:]])
    with pytest.raises(Conflict, match="other languages than before in 1 episode"):
        host.rescore()
    host.write(episodes, hidden=True)
    with pytest.raises(Conflict, match="hidden or for training before and is not now"):
        host.rescore()


def test_unchanged_data_is_refused(host: Host) -> None:
    with pytest.raises(Conflict, match="has not changed"):
        host.rescore()


def test_an_epoch_is_not_corrected(backend: LeaderboardBackend, tmp_path: Path) -> None:
    name = backend.epoch(1, tmp_path)
    before = backend.splits[name]
    episodes = [moved_cell(one) for one in before.episodes.values()]
    backend.splits[name] = write_split(
        tmp_path, name, hidden=True, source="tests", episodes=episodes, sections=[tiny.SECTION]
    )
    corrector = Corrector(backend.database, backend.splits, SigningKey(tmp_path / "key.pem"))
    with pytest.raises(Conflict, match="the host has committed to its data"):
        corrector.rescore(before, "x")


def test_runs_that_are_played_or_cannot_be_replayed_are_named(host: Host) -> None:
    play(host.backend.database, host.before, "open", {"0": (0,)}, over=False)
    play(host.backend.database, host.before, "broken", {"0": tiny.ACTIONS})
    with host.backend.database.write() as connection:
        at = sa.and_(tables.steps.c.run_id == "broken", tables.steps.c.step == 12)
        connection.execute(tables.steps.delete().where(at))
    host.replace(e0=moved_cell(host.before.episodes["0"]))
    found = host.rescore()
    assert found["open"].problem == "it is still being played"
    assert found["broken"].problem.startswith("it cannot be replayed: episode 0 ended by AGENT_FINISHED after 13 steps")
    host.backend.journal.set_state("open", CANCELLED)
    assert found["poor"].problem == ""
    assert host.backend.journal.run("broken").data_hash == host.before.data_hash


def test_a_receipt_that_is_signed_meanwhile_is_superseded_all_the_same(host: Host) -> None:
    host.replace(e0=moved_cell(host.before.episodes["0"]))
    going = host.corrector.rescore(host.before, "the cell was wrong")
    next(going)  # the correction is written, and one run scored again
    host.corrector.void("tiny", ["3"], "doubtful")
    old = Receipts(host.backend.database, {"tiny": host.before}, host.key)
    left = [
        name for name in ("good", "twin", "poor") if host.backend.journal.run(name).data_hash == host.before.data_hash
    ]
    for name in left:  # a server that still has the data as it was
        old.of(READER, name)
    list(going)
    for name in ("good", "twin", "poor"):
        content = host.content(name)
        assert [one["kind"] for one in content["corrections"]] == ["rescore", "void"]
        assert content["data_hash"] == host.splits["tiny"].data_hash
