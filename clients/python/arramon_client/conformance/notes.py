"""Checks of notes: stored beside their steps, once, within the limit, in histories, in pages, and private."""

from dataclasses import replace
from functools import partial

import grpc

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_client.conformance.assertions import expect, expect_equal, expect_refusal, need
from arramon_client.conformance.suite import check
from arramon_client.conformance.target import LEFT, RIGHT, Target
from arramon_client.transport.channel import open_channel
from arramon_client.transport.connection import CHANNEL_OPTIONS, METADATA

TEXT = 'to the mug\n{"goal": [3, 4], "दिशा": "बाएँ"}'
"""A note of two lines, in two scripts."""


@check("notes.stored", runs=1)
def stored(target: Target) -> None:
    """An act's note is stored with its step, unchanged, and ListNotes returns it; an act without a note stores none."""
    _need_notes(target, len(TEXT.encode()))
    run, episode_id = _play(target, "", TEXT, "")
    expect_equal("the list of notes", _listed(target, run), [(episode_id, 1, TEXT)])


@check("notes.repeated", runs=1)
def repeated(target: Target) -> None:
    """A step repeated with another note is answered again; the first note remains."""
    _need_notes(target)
    run = target.create()
    with target.play(run) as stream:
        _, _, start = stream.begin()
        for text in ("a", "b"):
            stream.send(_noted(start, LEFT, text))
            expect_equal("the step after the action", stream.observation().step, start.step + 1)
    expect_equal("the list of notes", _listed(target, run), [(start.episode_id, start.step, "a")])


@check("notes.too_long", runs=1)
def too_long(target: Target) -> None:
    """A note longer than `note_bytes` is a problem, NOTE_REFUSED, and is not stored; its action is taken."""
    _need_notes(target)
    run = target.create()
    with target.play(run) as stream:
        _, _, start = stream.begin()
        stream.send(_noted(start, LEFT, "m" * (target.info.note_bytes + 1)))
        stream.problem(pb.Problem.CODE_NOTE_REFUSED, start.episode_id)
        expect_equal("the step after the action", stream.observation().step, start.step + 1)
    expect_equal("the list of notes", _listed(target, run), [])


@check("notes.history", runs=1)
def history(target: Target) -> None:
    """In a history, each observation has the note that was stored with the action taken, and others have none."""
    run, episode_id = _play(target, "a", "", "c")
    with target.play(run, player="conformance", history=True) as stream:
        stream.next("opened")
        for step, text in enumerate(("a", None, "c", None)):
            while (seen := stream.observation()).episode_id != episode_id:
                pass
            found = seen.taken_note if seen.HasField("taken_note") else None
            expect_equal(f"the note in observation {step} of the history", found, text)


@check("notes.pages", runs=1)
def pages(target: Target) -> None:
    """ListNotes returns all notes by step, page by page, each once, and those of one episode if it is named."""
    run, episode_id = _play(target, "a", "b", "c")
    found, token = list[tuple[str, int, str]](), ""
    for _ in range(4):
        answer = _page(target, run, page_size=1, page_token=token)
        found += [(note.episode_id, note.step, note.text) for note in answer.notes]
        token = answer.next_page_token
        if not token:
            break
    everything = [(episode_id, step, text) for step, text in enumerate("abc")]
    expect_equal("the list of notes in pages of one", found, everything)
    expect_equal("the list of the episode's notes", _listed(target, run, episode_id=episode_id), everything)


@check("notes.private", runs=1)
def private(target: Target) -> None:
    """The notes of a run that is not published are hidden from callers without its participant's token: NOT_FOUND."""
    address, access = target.server.address, target.server.access
    need(access.token, "the suite plays without a token; one would make it run")
    run, _ = _play(target, "a")
    bare = replace(access, token="", tls=access.encrypts(address))
    with open_channel(address, bare, CHANNEL_OPTIONS) as channel:
        request = pb.ListNotesRequest(run_id=run.run_id)
        ask = partial(EvaluationStub(channel).ListNotes, request, timeout=target.timeout, metadata=METADATA)
        expect_refusal("ListNotes by a caller without a token", ask, grpc.StatusCode.NOT_FOUND)


@check("notes.refused", runs=1)
def refused(target: Target) -> None:
    """Notes of an unknown run or episode are refused: NOT_FOUND; a page of more than 2000 notes: INVALID_ARGUMENT."""
    _need_notes(target)
    run = target.create()
    for what, fields, code in (
        ("notes of an unknown run", {"run_id": "no such run"}, grpc.StatusCode.NOT_FOUND),
        ("notes of an unknown episode", {"episode_id": "no such episode"}, grpc.StatusCode.NOT_FOUND),
        ("a page of 2001 notes", {"page_size": 2001}, grpc.StatusCode.INVALID_ARGUMENT),
    ):
        request = pb.ListNotesRequest(**{"run_id": run.run_id, **fields})  # type: ignore[arg-type]
        expect_refusal(what, partial(target.call, "ListNotes", request), code)


def _need_notes(target: Target, size: int = 1) -> None:
    """Raise Skipped unless the server stores notes of this size in bytes."""
    most = target.info.note_bytes
    need(size <= most, f"the server stores notes of at most {most} bytes; one that stores {size} would make it run")


def _noted(seen: pb.Observation, action: types_pb2.Action.ValueType, text: str) -> pb.Act:
    """Return an act with a note."""
    return pb.Act(episode_id=seen.episode_id, step=seen.step, action=action, note=text)


def _play(target: Target, *texts: str) -> tuple[pb.Run, str]:
    """Play a step with each of these notes in a new run; return the run and the episode's id."""
    _need_notes(target)
    run = target.create()
    with target.play(run, player="conformance") as stream:
        _, _, seen = stream.begin()
        for number, text in enumerate(texts):
            stream.send(_noted(seen, (LEFT, RIGHT)[number % 2], text))
            seen = stream.observation()
    return run, seen.episode_id


def _page(target: Target, run: pb.Run, **fields: object) -> pb.ListNotesResponse:
    answer: pb.ListNotesResponse = target.call("ListNotes", pb.ListNotesRequest(run_id=run.run_id, **fields))  # type: ignore[arg-type]
    return answer


def _listed(target: Target, run: pb.Run, **fields: object) -> list[tuple[str, int, str]]:
    """Return the notes of a run, which fit on one page, as tuples of episode, step and text."""
    answer = _page(target, run, **fields)
    expect(not answer.next_page_token, "the first page of three notes is not the last, expected all of them on it")
    return [(note.episode_id, note.step, note.text) for note in answer.notes]


CHECKS = (stored, repeated, too_long, history, pages, private, refused)
