"""What the write page does with a task: opens it in a window, saves its draft, submits it. Called in threads."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from arramon_collecting.rules.clean_text import clean_instructions
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.texts.records import Text
from arramon_collecting.storage.work.drafts import OlderDraft
from arramon_collecting.storage.work.records import EXPIRED, OPEN, SUBMITTED, WRITE, Draft, Task
from arramon_collecting.web.texts import texts_of
from arramon_collecting.web.writing.requests import EVIDENCE, Written
from arramon_collecting.web.writing.sentences import finding_as_json, sentence
from arramon_collecting.writing.characters import stored_form
from arramon_collecting.writing.checks import Finding, TextChecker, any_blocks
from arramon_collecting.writing.walk import DONE, PARTS, begin, read_position
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput, Conflict, NotFound, Unavailable
from arramon_server.sim.catalogue import ObjectType
from arramon_server.web.page_texts import DEFAULT_LANGUAGE, PageTexts

Findings = tuple[tuple[Finding, ...], ...]
"""Findings of each text, by part."""


class Blocked(BadInput):
    """A submitted text fails a check that blocks it.

    Args:
        findings: of all texts, by part.
    """

    def __init__(self, findings: Findings) -> None:
        super().__init__("a text fails a check; mend it and submit again")
        self.findings = findings


@dataclass(frozen=True, slots=True)
class OpenTask:
    """A task with what it is about.

    Attributes:
        collection: its collection.
        task: the task.
        episode: the episode that is written for.
        checker: checks its texts.
    """

    collection: Collection
    task: Task
    episode: Episode
    checker: TextChecker

    def findings(self, texts: Sequence[str]) -> Findings:
        """Return the findings of each text; none of one that is not begun."""
        return tuple(self.checker.findings(text, part) if text.strip() else () for part, text in enumerate(texts))

    def as_json(self, t: PageTexts, texts: Sequence[str], findings: Findings) -> list[list[dict[str, Any]]]:
        """Return the findings of each text for the page."""
        return [
            [finding_as_json(t, finding, text, self.target(part)) for finding in found]
            for part, (text, found) in enumerate(zip(texts, findings, strict=True))
        ]

    def as_failures(self, findings: Findings) -> list[dict[str, Any]]:
        """Return the findings as they are stored with a text: an English message, and what hosts' pages say of them."""
        t = texts_of(DEFAULT_LANGUAGE)
        return [
            {
                "turn": PARTS[part][0],
                "phase": PARTS[part][1],
                "check": finding.check,
                "severity": finding.severity,
                "message": sentence(t, finding, self.target(part)),
                "words": list(finding.words),
                "expected": finding.expected,
            }
            for part, found in enumerate(findings)
            for finding in found
        ]

    def target(self, part: int) -> ObjectType:
        """Return the object that a part's text is about."""
        return self.episode.turns[PARTS[part][0] - 1].target.type


class WriteTasks:
    """Tasks of writing.

    Args:
        store: storage of the collections.
        splits: splits by name.
    """

    def __init__(self, store: Store, splits: Mapping[str, Split]) -> None:
        self._store = store
        self._splits = splits

    def find(self, collection: Collection, worker: Worker, task_id: str) -> OpenTask:
        """Return a worker's task of writing, in any state.

        Raises:
            NotFound: if the worker has none of that id, or its episode is not served any more.
        """
        task = self._store.tasks.of_worker(worker, task_id)
        split = self._splits.get(collection.split)
        episode = split.episodes.get(task.episode_id) if split is not None else None
        if task.stage != WRITE or split is None or episode is None:
            raise NotFound(f"there is no task of writing {task_id!r}")
        section = split.sections[episode.section]
        checker = TextChecker(episode, section, collection.language, collection.settings.max_characters)
        return OpenTask(collection, task, episode, checker)

    def find_open(self, collection: Collection, worker: Worker, task_id: str) -> OpenTask:
        """Return a worker's open task of writing; one that has expired is opened again if nobody else does it.

        Raises:
            NotFound: as for `find`.
            Conflict: if it is not open any more.
        """
        found = self.find(collection, worker, task_id)
        if found.task.state == EXPIRED:
            return replace(found, task=self._store.tasks.resume(found.task))
        if found.task.state != OPEN:
            raise Conflict(f"the task is {found.task.state}, expected an open one")
        return found

    def open_in(self, task: OpenTask, editor: str) -> tuple[int, Draft]:
        """Make a window the one that writes a task; return the revision before, and the draft.

        Raises:
            Unavailable: if several windows do this at once.
        """
        for _ in range(3):
            draft = self._store.drafts.get(task.task.task_id)
            written = replace(Written.of_body(draft.body, self._begun(task)), editor=editor)
            try:
                return draft.revision, self._save(task, draft.revision, written)
            except OlderDraft:
                continue
        raise Unavailable("several windows open this task at once; try again in a moment")

    def draft(self, task: OpenTask) -> Draft:
        """Return the saved draft."""
        return self._store.drafts.get(task.task.task_id)

    def save(self, task: OpenTask, revision: int, written: Written) -> Draft:
        """Save a draft, on top of the revision that the page had.

        Raises:
            OlderDraft: if another window has saved since, with its draft.
            BadInput: if the position is none of the episode.
            Conflict: if the task is not open any more.
        """
        read_position(written.position, task.episode)
        return self._save(task, revision, written)

    def submit(self, task: OpenTask, submission: str, written: Written) -> None:
        """Submit the texts of a task. The same submission again changes nothing.

        Raises:
            OlderDraft: if another window writes the task now, with its draft.
            BadInput: if the writer has not been through all parts.
            Blocked: if a text fails a check that blocks it.
            Conflict: if the task is not open any more.
        """
        texts = [stored_form(text, task.collection.language) for text in written.texts]
        if task.task.state != SUBMITTED:
            draft = self.draft(task)
            if draft.body and draft.body["editor"] != written.editor:
                raise OlderDraft(draft, 0)
            if read_position(written.position, task.episode).reached < DONE:
                raise BadInput("not all parts have been walked through; walk to the end and place both objects first")
        findings = tuple(task.checker.findings(text, part) for part, text in enumerate(texts))
        if any(map(any_blocks, findings)):
            raise Blocked(findings)
        pairs = clean_instructions([texts[:2], texts[2:]], task.collection.settings.max_characters)
        failures = task.as_failures(findings)
        evidence = {name: count for name, count in written.evidence.items() if count}
        self._store.submissions.submit_text(task.collection, task.task, submission, pairs, failures, evidence)

    def reason(self, task: OpenTask) -> str:
        """Return why a host sent the text back that a task mends; "" for a new text."""
        earlier = self._sent_back(task.task)
        return earlier.reason if earlier is not None else ""

    def _save(self, task: OpenTask, revision: int, written: Written) -> Draft:
        body = written.as_body()
        size = len(json.dumps(body, ensure_ascii=False).encode())
        return self._store.drafts.save(task.task, revision, body, size=size)

    def _begun(self, task: OpenTask) -> Written:
        """Return what a page shows first: nothing, or the text that was sent back."""
        position, texts = begin(task.episode), ("",) * len(PARTS)
        if (earlier := self._sent_back(task.task)) is not None:
            position = replace(position, reached=DONE)
            texts = tuple(text for pair in earlier.instructions for text in pair)
        return Written("", str(position), texts, dict.fromkeys(EVIDENCE, 0))

    def _sent_back(self, task: Task) -> Text | None:
        """Return the text that a task mends; None for a new text."""
        return None if task.text_id is None or task.state == SUBMITTED else self._store.texts.get(task.text_id)
