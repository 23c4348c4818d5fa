"""Faults in notes: lost, replaced, cut, and shown to others."""

from typing import Any

from arramon.v1 import evaluation_pb2 as pb
from tests.conformance.breakers.faults import acts, again, answers, clears, events, requests, sets
from tests.conformance.forwarder import Fault, Stream


def without_notes(sent: list[pb.Act], _: Stream) -> None:
    for act in sent:
        act.ClearField("note")


def changes(**fields: Any) -> Fault:
    """A fault that changes every listed note."""

    def change(answer: pb.ListNotesResponse) -> None:
        for note in answer.notes:
            sets(**fields)(note)

    return answers("ListNotes", change)


NOTES = [
    ("notes.stored", answers("ListNotes", clears("notes")), r"the list of notes is \[\], expected \[\('"),
    ("notes.stored", changes(step=0), "the list of notes is "),
    ("notes.stored", changes(text="to the mug {}"), "the list of notes is "),
    ("notes.stored", answers("ListNotes", sets(next_page_token="more")), "first page of three notes is not the last"),
    ("notes.repeated", changes(text="b"), "the list of notes is .*'b'"),
    ("notes.too_long", acts(without_notes), "the stream sent observation, expected problem"),
    ("notes.too_long", answers("ListNotes", lambda page: page.notes.add(text="mmm")), "the list of notes is .*'mmm'"),
    (
        "notes.history",
        events("observation", clears("taken_note"), again),
        "the note in observation 0 of the history is None, expected 'a'",
    ),
    (
        "notes.history",
        events("observation", sets(taken_note="a"), again),
        "the note in observation 1 of the history is 'a', expected None",
    ),
    ("notes.pages", answers("ListNotes", clears("next_page_token")), "the list of notes in pages of one is "),
    ("notes.pages", requests("ListNotes", page_token=""), "the list of notes in pages of one is "),
    ("notes.pages", answers("ListNotes", lambda page: sets(next_page_token="")(page)), "in pages of one is "),
    ("notes.refused", requests("ListNotes", page_size=0), "a page of 2001 notes was accepted"),
    ("notes.refused", requests("ListNotes", episode_id=""), "notes of an unknown episode was accepted"),
]
