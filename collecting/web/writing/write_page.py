"""The page on which a worker writes, `/LANGUAGE/collect/NAME/write/TASK`, and what its scripts ask for."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from aiohttp import web

from arramon_collecting.storage.work.records import Draft
from arramon_collecting.web.access import Visitor
from arramon_collecting.web.handlers import BASE, Handlers, home_address, json_response, request_texts
from arramon_collecting.web.writing.guidelines import guidelines_context, written_texts
from arramon_collecting.web.writing.requests import read_draft, read_editor, read_submission
from arramon_collecting.web.writing.write_tasks import Blocked, OpenTask, WriteTasks
from arramon_collecting.writing.bends import NO_BEND, Bend, bend_of
from arramon_collecting.writing.characters import MAX_TEXT_CHARACTERS
from arramon_collecting.writing.pictures import WriterPictures
from arramon_collecting.writing.walk import (
    PARTS,
    Move,
    Position,
    enter,
    moved,
    preview,
    read_position,
    target_bearing,
)
from arramon_server.errors import BadInput, quoted
from arramon_server.playback.pictures import as_jpeg
from arramon_server.web.http_responses import HEADERS
from arramon_server.web.named_things import object_name
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.watch.frame_queue import ClientLeft, FrameQueue

TASK = f"{BASE}/write/{{task:[0-9a-f]{{32}}}}"
"""Address of the page."""

NAME = "write"
"""First part of the names of the page's template and static files."""


PREVIEW_SIZE = 128
"""Side length of the picture of the other phase, in pixels."""


class WritePage:
    """The write page.

    Args:
        handlers: what all pages of collections share.
        tasks: the tasks of writing.
        pictures: draws what writers see; closed with the page.
        size: side length of the pictures, in pixels.
    """

    def __init__(self, handlers: Handlers, tasks: WriteTasks, pictures: WriterPictures, size: int) -> None:
        self._handlers = handlers
        self._tasks = tasks
        self._pictures = pictures
        self._size = size
        self._frames = FrameQueue() if pictures.draws_in_threads else FrameQueue(1)

    def routes(self) -> list[web.RouteDef]:
        """Return the routes of the page."""
        guarded = self._handlers.guarded
        return [
            web.get(TASK, guarded(self._page)),
            web.get(f"{TASK}/view", guarded(self._view)),
            web.get(f"{TASK}/preview", guarded(self._preview)),
            web.get(f"{TASK}/draft", guarded(self._draft)),
            web.post(f"{TASK}/open", guarded(self._open)),
            web.post(f"{TASK}/draft", guarded(self._save)),
            web.post(f"{TASK}/submit", guarded(self._submit)),
        ]

    def close(self) -> None:
        """Draw no more, and free the scenes."""
        self._frames.close()
        self._pictures.close()

    async def _page(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            task = self._tasks.find_open(collection, visitor.worker, request.match_info["task"])
            t = request_texts(request)
            context = {
                "settings": self._settings(t, task, visitor, request.path),
                "language": collection.language,
                "reason": self._tasks.reason(task),
                "has_passed": "passed" in request.query,
                **guidelines_context(t, collection, is_open=False),
            }
            return self._handlers.page(request, "write/write.html", collection, context, visitor=visitor)

        return await self._handlers.run(make)

    def _settings(self, t: PageTexts, task: OpenTask, visitor: Visitor, base: str) -> dict[str, Any]:
        prefix, written = "collect_write_js.", written_texts(t, task.collection)
        return {
            "base": base,
            "csrf": visitor.csrf,
            "task": task.task.task_id,
            "size": self._size,
            "language": task.collection.language,
            "max_characters": task.collection.settings.max_characters,
            "max_kept": MAX_TEXT_CHARACTERS,
            "parts": [
                {"turn": turn, "phase": phase, "target": object_name(written, task.target(part))}
                for part, (turn, phase) in enumerate(PARTS)
            ],
            "texts": {key.removeprefix(prefix): text for key, text in t.words.items() if key.startswith(prefix)},
        }

    async def _view(self, request: web.Request) -> web.StreamResponse:
        """Answer with the picture after a move, and where the writer is then in the headers. Nothing is stored."""

        def find() -> tuple[OpenTask, Seen]:
            task = self._open_task(request)
            return task, _moved(request.query, task)

        task, seen = await self._handlers.run(find)
        line = task.episode.turns[seen.position.turn - 1].path
        bearing = target_bearing(seen.position, task.episode)
        facts = {
            "Arramon-Position": str(seen.position),
            "Arramon-Outcome": seen.outcome,
            "Arramon-Bend": f"{seen.bend.angle} {seen.bend.net} {'later' if seen.bend.is_later else 'first'}",
            "Arramon-Progress": f"{seen.position.place / max(1, len(line) - 1):.3f}",
            "Arramon-Bearing": "" if bearing is None else f"{bearing:.0f}",
        }
        return await self._picture(request, task, seen.position, self._size, facts)

    async def _preview(self, request: web.Request) -> web.StreamResponse:
        """Answer with the small picture of the turn's other phase."""

        def find() -> tuple[OpenTask, Position]:
            task = self._open_task(request)
            return task, preview(read_position(request.query.get("at", ""), task.episode), task.episode)

        task, position = await self._handlers.run(find)
        return await self._picture(request, task, position, PREVIEW_SIZE, {})

    def _open_task(self, request: web.Request) -> OpenTask:
        collection, visitor = self._handlers.visitor(request)
        return self._tasks.find_open(collection, visitor.worker, request.match_info["task"])

    async def _picture(
        self, request: web.Request, task: OpenTask, position: Position, size: int, facts: Mapping[str, str]
    ) -> web.StreamResponse:
        """Answer with the view at a position, and with facts as headers."""
        split, transport = task.collection.split, request.transport

        def draw() -> bytes:
            return as_jpeg(self._pictures.draw(split, task.episode, position, size))

        try:
            jpeg = await self._frames.frame(
                (split, task.episode.episode_id, f"{position} {size}"),
                draw,
                lambda: transport is None or transport.is_closing(),
            )
        except ClientLeft:
            return web.Response(status=499)
        headers = {**HEADERS, "Cache-Control": "no-store", **facts}
        return web.Response(body=jpeg, headers=headers, content_type="image/jpeg")

    async def _draft(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            task = self._tasks.find_open(collection, visitor.worker, request.match_info["task"])
            draft = self._tasks.draft(task)
            return json_response({"revision": draft.revision, "editor": draft.body.get("editor", "")})

        return await self._handlers.run(make)

    async def _open(self, request: web.Request) -> web.Response:
        def do(task: OpenTask, fields: Mapping[str, Any], t: PageTexts) -> dict[str, Any]:
            before, draft = self._tasks.open_in(task, read_editor(fields))
            return {"before": before, **draft.body, **_saved(task, draft, t)}

        return await self._change(request, do)

    async def _save(self, request: web.Request) -> web.Response:
        def do(task: OpenTask, fields: Mapping[str, Any], t: PageTexts) -> dict[str, Any]:
            return _saved(task, self._tasks.save(task, *read_draft(fields)), t)

        return await self._change(request, do)

    async def _submit(self, request: web.Request) -> web.Response:
        address = f"{home_address(request)}?notice=sent"

        def do(task: OpenTask, fields: Mapping[str, Any], _: PageTexts) -> dict[str, Any]:
            self._tasks.submit(task, *read_submission(fields))
            return {"next": address}

        return await self._change(request, do, in_any_state=True)

    async def _change(
        self,
        request: web.Request,
        do: Callable[[OpenTask, Mapping[str, Any], PageTexts], dict[str, Any]],
        *,
        in_any_state: bool = False,
    ) -> web.Response:
        """Answer a request of the page's scripts that changes the task."""
        fields = await self._handlers.json(request)
        find = self._tasks.find if in_any_state else self._tasks.find_open

        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            self._handlers.check(request, visitor)
            task = find(collection, visitor.worker, request.match_info["task"])
            t = request_texts(request)
            try:
                return json_response(do(task, fields, t))
            except Blocked as error:
                texts = fields["texts"]
                return json_response({"error": str(error), "findings": task.as_json(t, texts, error.findings)}, 422)

        return await self._handlers.run(make)


@dataclass(frozen=True, slots=True)
class Seen:
    """Where a writer is after a request.

    Attributes:
        position: the position.
        outcome: what the move did; "" without one.
        bend: how the line turned the writer in it.
    """

    position: Position
    outcome: str = ""
    bend: Bend = NO_BEND


def _moved(query: Mapping[str, str], task: OpenTask) -> Seen:
    """Return where a writer is after what a query asks for."""
    position = read_position(query.get("at", ""), task.episode)
    if "part" in query:
        if not (query["part"].isascii() and query["part"].isdecimal() and len(query["part"]) < 4):
            raise BadInput(f"part {quoted(query['part'])}, expected a number")
        return Seen(enter(position, int(query["part"]), task.episode))
    if "move" not in query:
        return Seen(position)
    if query["move"] not in list(Move):
        raise BadInput(f"move {quoted(query['move'])}, expected one of {', '.join(Move)}")
    move = Move(query["move"])
    after, outcome = moved(position, move, task.episode)
    return Seen(after, outcome, bend_of(position, move, after, task.episode))


def _saved(task: OpenTask, draft: Draft, t: PageTexts) -> dict[str, Any]:
    texts = draft.body["texts"]
    return {"revision": draft.revision, "findings": task.as_json(t, texts, task.findings(texts))}
