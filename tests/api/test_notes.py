"""Notes over gRPC: stored with their steps, cleaned, limited, listed in pages, and sent in histories."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_server.runs import run_notes
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from tests import tiny
from tests.api.player import FORWARD, LEFT, Player, create
from tests.api.test_runs import refused
from tests.serving import METADATA, Server

LONGEST = 2048


def noted(episode_id: str, step: int, note: str, action: int = FORWARD) -> pb.Act:
    return pb.Act(episode_id=episode_id, step=step, action=action, note=note)  # type: ignore[arg-type]


def page(stub: EvaluationStub, run_id: str, **fields: object) -> pb.ListNotesResponse:
    request = pb.ListNotesRequest(run_id=run_id, **fields)  # type: ignore[arg-type]
    return stub.ListNotes(request, metadata=METADATA)


def listed(stub: EvaluationStub, run_id: str, **fields: object) -> list[tuple[str, int, str]]:
    return [(note.episode_id, note.step, note.text) for note in page(stub, run_id, **fields).notes]


def played_with_notes(stub: EvaluationStub, notes: list[str], **fields: object) -> tuple[str, str]:
    """Play as many steps to the left as there are notes; return the ids of the run and its episode."""
    run_id = create(stub, **{"episodes": 1, **fields}).run_id
    with Player(stub, run_id) as player:
        seen = player.observation()
        for step, note in enumerate(notes):
            player.send([noted(seen.episode_id, step, note, LEFT)])
            assert player.observation().step == step + 1
    return run_id, seen.episode_id


@pytest.mark.parametrize(
    ("sent", "stored"),
    [
        ("I read: go to the mug", "I read: go to the mug"),
        ('{"goal":[3,4],"words":["बाईं"]}', '{"goal":[3,4],"words":["बाईं"]}'),
        ("one\r\n\ttwo\n", "one\n\ttwo\n"),
        ("red \x1b[31m\x00", "red \ufffd[31m\ufffd"),
        ("m" * LONGEST, "m" * LONGEST),
        ("\x1b" + "m" * (LONGEST - 3), "\ufffd" + "m" * (LONGEST - 3)),
    ],
    ids=range(6),
)
def test_a_note_is_stored_beside_its_step(stub: EvaluationStub, sent: str, stored: str) -> None:
    run_id, episode_id = played_with_notes(stub, ["", sent])
    assert listed(stub, run_id) == [(episode_id, 1, stored)]


def test_an_act_that_is_repeated_stores_no_second_note(stub: EvaluationStub) -> None:
    run_id = create(stub, episodes=1).run_id
    with Player(stub, run_id) as player:
        start = player.observation()
        for note in ("first", "second"):
            player.send([noted(start.episode_id, 0, note), noted(start.episode_id, 0, note)])
            assert [player.observation().step, player.observation().step] == [1, 1]
        player.send([noted(start.episode_id, 0, "another action", LEFT)])
        assert player.problem().code == pb.Problem.CODE_STEP_BEHIND
    assert listed(stub, run_id) == [(start.episode_id, 0, "first")]


@pytest.mark.parametrize(
    ("note", "size"),
    [("m" * (LONGEST + 1), LONGEST + 1), ("ह" * 683, 2049), ("\x00" * 683, 2049), ("m" * 500_000, 500_000)],
    ids=range(4),
)
def test_a_note_that_is_too_long_is_refused_and_its_action_taken(stub: EvaluationStub, note: str, size: int) -> None:
    run_id = create(stub, episodes=1).run_id
    with Player(stub, run_id) as player:
        start = player.observation()
        player.send([noted(start.episode_id, 0, note)])
        problem = player.problem()
        assert (problem.code, problem.episode_id, problem.step) == (pb.Problem.CODE_NOTE_REFUSED, start.episode_id, 0)
        assert problem.message == (
            f"episode {start.episode_id!r}: the action was taken, but its note not stored: "
            f"the note has {size} bytes in UTF-8, expected at most 2048"
        )
        assert player.observation().step == 1
    assert listed(stub, run_id) == []


def test_notes_of_acts_that_are_not_taken_are_dropped(stub: EvaluationStub) -> None:
    run_id = create(stub, episodes=1).run_id
    with Player(stub, run_id) as player:
        start = player.observation()
        player.send([noted(start.episode_id, 5, "ahead"), noted(start.episode_id, 0, "none", 4), noted("x", 0, "no")])
        codes = [player.problem().code for _ in range(3)]
        player.send([pb.Act(episode_id=start.episode_id, forfeit=pb.Forfeit(reason="enough"), note="given up")])
        while not player.next().HasField("run_ended"):
            pass
    assert codes == [
        pb.Problem.CODE_STEP_AHEAD,
        pb.Problem.CODE_BAD_ACTION,
        pb.Problem.CODE_NOT_YOUR_EPISODE,
    ]
    assert listed(stub, run_id) == []


def test_a_history_has_each_note_with_the_action_that_was_taken(stub: EvaluationStub) -> None:
    run_id, episode_id = played_with_notes(stub, ["one", "", "three"])
    with Player(stub, run_id, adopt=True, history=True) as player:
        past = [player.observation() for _ in range(4)]
    assert [(seen.step, seen.HasField("taken"), seen.HasField("taken_note")) for seen in past] == [
        (0, True, True), (1, True, False), (2, True, True), (3, False, False),
    ]  # fmt: skip
    assert [seen.taken_note for seen in past] == ["one", "", "three", ""]
    assert {seen.episode_id for seen in past} == {episode_id}


def test_notes_are_listed_in_pages(stub: EvaluationStub) -> None:
    run_id = create(stub, episodes=2).run_id
    with Player(stub, run_id, 2) as player:
        episodes = [player.observation().episode_id, player.observation().episode_id]
        for step in range(3):
            player.send([noted(episode_id, step, f"{episode_id} {step}", LEFT) for episode_id in episodes])
            assert {player.observation().step, player.observation().step} == {step + 1}
    everything = [(episode_id, step, f"{episode_id} {step}") for episode_id in sorted(episodes) for step in range(3)]
    assert listed(stub, run_id) == everything
    assert page(stub, run_id).next_page_token == ""
    assert listed(stub, run_id, episode_id=episodes[1]) == [each for each in everything if each[0] == episodes[1]]
    for size in (1, 2, 4, 6):
        found, token, pages = [], "", 0
        while pages == 0 or token:
            answer = page(stub, run_id, page_size=size, page_token=token)
            found += [(note.episode_id, note.step, note.text) for note in answer.notes]
            token, pages = answer.next_page_token, pages + 1
        assert (found, pages) == (everything, -(-6 // size))


def test_a_page_ends_before_it_is_too_large_for_a_message(
    stub: EvaluationStub, monkeypatch: pytest.MonkeyPatch, server: Server
) -> None:
    run_id, _ = played_with_notes(stub, ["m" * 2000] * 3)
    with journal_of(server.data) as journal:
        monkeypatch.setattr(run_notes, "PAGE_BYTES", 4000)
        notes = run_notes.RunNotes({}, journal)
        first, token = notes.page(HOST, run_id)
        second, end = notes.page(HOST, run_id, token=token)
        assert ([note.step for note in first], [note.step for note in second], end) == ([0, 1], [2], "")
        monkeypatch.setattr(run_notes, "PAGE_BYTES", 10)  # a page has at least one note
        assert [note.step for note in notes.page(HOST, run_id)[0]] == [0]


@contextmanager
def journal_of(data: Path) -> Iterator[Journal]:
    database = Database(f"sqlite:///{data / 'journal.db'}")
    try:
        yield Journal(database)
    finally:
        database.close()


@pytest.mark.parametrize(
    ("fields", "status", "message"),
    [
        ({"page_size": 2001}, "INVALID_ARGUMENT", "page_size is 2001, expected 1 to 2000, or 0 for 500"),
        (
            {"page_token": "3"},
            "INVALID_ARGUMENT",
            "page_token is '3', expected the next_page_token of the previous page",
        ),
        ({"page_token": "-1:0"}, "INVALID_ARGUMENT", "page_token is '-1:0', expected the next_page_token of the prev"),
        (
            {"page_token": "1:\0"},
            "INVALID_ARGUMENT",
            r"page_token is '1:\x00', expected the next_page_token of the prev",
        ),
        ({"episode_id": "nowhere"}, "NOT_FOUND", "has no episode 'nowhere'"),
        ({"episode_id": "\0"}, "NOT_FOUND", r"has no episode '\x00'"),
        ({"run_id": "b" * 32}, "NOT_FOUND", "there is no run 'bbbb"),
        ({"run_id": "\0"}, "NOT_FOUND", "there is no run"),
    ],
)
def test_wrong_requests_are_refused(stub: EvaluationStub, fields: dict[str, object], status: str, message: str) -> None:
    request = pb.ListNotesRequest(**{"run_id": create(stub, episodes=1).run_id, **fields})  # type: ignore[arg-type]
    code, details = refused(lambda: stub.ListNotes(request, metadata=METADATA))
    assert (code.name, message in details) == (status, True), details


def test_notes_change_neither_play_nor_receipt(stub: EvaluationStub, server: Server) -> None:
    runs, receipts = [], []
    for note in ("", "what I read"):
        runs.append(create(stub).run_id)
        with Player(stub, runs[-1]) as player:
            while not (event := player.next()).HasField("run_ended"):
                if event.HasField("observation"):
                    seen = event.observation
                    player.send([noted(seen.episode_id, seen.step, note, int(tiny.ACTIONS[seen.step]))])
        receipts.append(stub.GetReceipt(pb.GetReceiptRequest(run_id=runs[-1]), metadata=METADATA).payload)
    with journal_of(server.data) as journal:
        plain, with_notes = (journal.play_digest(journal.run(run_id)) for run_id in runs)
        assert journal.notes_size(runs[1]) == 6 * len(tiny.ACTIONS) * len("what I read")
    assert plain == with_notes
    assert b"what I read" not in receipts[1]
    assert len(listed(stub, runs[1])) == 6 * len(tiny.ACTIONS)


@pytest.mark.parametrize(
    ("settings", "offered", "stored", "reason"),
    [
        (("--note-bytes", "0"), 0, [], "this server does not store notes (note_bytes is 0)"),
        (("--note-bytes", "3"), 3, [], "the note has 4 bytes in UTF-8, expected at most 3"),
        (
            ("--run-note-bytes", "9"),
            2048,
            [0, 1],
            "the run's notes have 8 bytes, and 4 more would exceed the limit of 9",
        ),
    ],
    ids=["off", "one", "all"],
)
def test_the_hosts_limits_are_kept(
    tmp_path: Path, settings: tuple[str, ...], offered: int, stored: list[int], reason: str
) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path, "127.0.0.1:0", "--steps", "8", *settings)
    with grpc.insecure_channel(server.address) as channel:
        stub = EvaluationStub(channel)
        assert stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA).note_bytes == offered
        run_id = create(stub, episodes=1).run_id
        for connection in range(2):  # a stream that comes back finds the allowance as it was
            with Player(stub, run_id, adopt=True, player=str(connection), history=False) as player:
                seen = player.observation()
                while seen.HasField("taken"):
                    seen = player.observation()
                for step in range(seen.step, seen.step + 3):
                    player.send([noted(seen.episode_id, step, "four", LEFT)])
                    if step not in stored:
                        assert player.problem().message.endswith(reason)
                    assert player.observation().step == step + 1
        assert [note[1] for note in listed(stub, run_id)] == stored
    assert server.stop() == 0
