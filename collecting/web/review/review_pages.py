"""The host's review: the overview of a collection, the page of one text, and decisions about it."""

import hashlib
from collections.abc import Mapping
from typing import Any

from aiohttp import web

from arramon_collecting.storage.mail_queue import Letter
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import REVIEW_KIND, Collection
from arramon_collecting.storage.texts.records import IN_REVIEW, Text
from arramon_collecting.web.access import Visitor
from arramon_collecting.web.handlers import BASE, Handlers, request_texts, see_other
from arramon_collecting.web.review.host_view import CollectionRows, collection_address, common
from arramon_collecting.web.review.letters import letter_for
from arramon_collecting.web.review.review_forms import ReviewFormError, mended_instructions, reason_of
from arramon_collecting.web.review.review_overview import overview_context
from arramon_collecting.web.review.review_text_view import text_context
from arramon_server.episodes.split_lookup import SplitLookup
from arramon_server.errors import BadInput, Conflict, NotFound, quoted

ACCEPT, MEND, SEND_BACK, REJECT = "accept", "mend", "send_back", "reject"
"""Decisions about a text."""

TEXT = f"{BASE}/review/{{text:[0-9a-f]{{32}}}}"


class ReviewPages:
    """The pages, for hosts only.

    Args:
        handlers: what all pages of collections share.
        splits: the served splits, by name.
    """

    def __init__(self, handlers: Handlers, splits: SplitLookup) -> None:
        self._handlers = handlers
        self._splits = splits

    def routes(self) -> list[web.RouteDef]:
        """Return the routes."""
        guarded = self._handlers.guarded
        decision = f"{{decision:{ACCEPT}|{MEND}|{SEND_BACK}|{REJECT}}}"
        return [
            web.get(f"{BASE}/review", guarded(self._list)),
            web.get(TEXT, guarded(self._show)),
            web.post(f"{TEXT}/{decision}", guarded(self._decide)),
        ]

    def close(self) -> None:
        """Do nothing: there is nothing to end."""

    async def _list(self, request: web.Request) -> web.StreamResponse:
        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request, host=True)
            store, split = self._handlers.store, self._splits.get(collection.split)
            rows = CollectionRows.read(store, collection)
            t, state = request_texts(request), request.query.get("state", "")
            context = overview_context(t, collection, rows, split, state, store.clock())
            return self._handlers.page(
                request, "collect/review.html", collection, common(request, "review") | context, visitor=visitor
            )

        return await self._handlers.run(make)

    async def _show(self, request: web.Request) -> web.StreamResponse:
        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request, host=True)
            text = self._text(request, collection)
            return self._handlers.page(
                request,
                "collect/review_text.html",
                collection,
                self._context(request, collection, visitor.worker, text),
                visitor=visitor,
            )

        return await self._handlers.run(make)

    def _context(self, request: web.Request, collection: Collection, host: Worker, text: Text) -> dict[str, Any]:
        verifications = self._handlers.store.verifications.of_text(text.text_id)
        split = self._splits.get(collection.split)
        context = text_context(request_texts(request), collection, text, verifications, split)
        form = {"problem": "", "given": {}}
        return common(request, "") | context | form | {"next_text": self._next(collection, host, text.text_id)}

    async def _decide(self, request: web.Request) -> web.StreamResponse:
        fields = await self._handlers.form(request)

        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request, host=True)
            self._handlers.check(request, visitor, fields)
            try:
                text = self._decided(request, collection, visitor, fields)
            except ReviewFormError as error:
                return self._again(request, collection, visitor, fields, str(error))
            address, query = f"{collection_address(request)}/review", f"?decided={text.state}"
            following = self._next(collection, visitor.worker, text.text_id)
            return see_other(f"{address}/{following}{query}" if following else f"{address}{query}")

        return await self._handlers.run(make)

    def _again(
        self, request: web.Request, collection: Collection, visitor: Visitor, fields: Mapping[str, str], problem: str
    ) -> web.Response:
        """Show a text's page with what is wrong, and what was typed."""
        context = self._context(request, collection, visitor.worker, self._text(request, collection))
        given = fields if request.match_info["decision"] == MEND else {}
        return self._handlers.page(
            request,
            "collect/review_text.html",
            collection,
            context | {"here_address": request.path.rpartition("/")[0], "problem": problem, "given": given},
            visitor=visitor,
            status=400,
        )

    def _decided(
        self, request: web.Request, collection: Collection, visitor: Visitor, fields: Mapping[str, str]
    ) -> Text:
        """Carry a decision out; return the text as it is then."""
        reviews, host = self._handlers.store.reviews, visitor.worker
        text_id, decision = request.match_info["text"], request.match_info["decision"]
        version = _version(fields)
        if decision == ACCEPT:
            return reviews.accept(collection, text_id, version, host, self._letter(request, collection, "accepted", ""))
        if decision == MEND:
            if collection.kind != REVIEW_KIND:
                raise Conflict("only generated texts are mended by those who review them; send the text back instead")
            instructions = mended_instructions(request_texts(request), collection, fields)
            if instructions != self._text(request, collection).instructions:
                version = reviews.mend(collection, text_id, version, host, instructions).version
            return reviews.accept(collection, text_id, version, host)
        reason = reason_of(request_texts(request), fields)
        if decision == SEND_BACK:
            letter = self._letter(request, collection, "sent_back", reason)
            return reviews.send_back(collection, text_id, version, host, reason, letter)
        letter = self._letter(request, collection, "rejected", reason)
        return reviews.reject(collection, text_id, version, host, reason, letter)

    def _letter(self, request: web.Request, collection: Collection, decision: str, reason: str) -> Letter | None:
        text = self._text(request, collection)
        if text.worker_id is None:
            return None
        author = self._handlers.store.workers.get(text.worker_id)
        site = f"{request.headers.get('X-Forwarded-Proto', request.scheme)}://{request.host}"
        return letter_for(collection, author, decision, reason=reason, site=site)

    def _text(self, request: web.Request, collection: Collection) -> Text:
        text = self._handlers.store.texts.get(request.match_info["text"])
        if text.collection != collection.name:
            raise NotFound(f"there is no text {quoted(text.text_id)} in this collection")
        return text

    def _next(self, collection: Collection, host: Worker, but: str) -> str:
        """Return the id of another text in review, in an order of the host's own; empty if there is none.

        Hosts who review at the same time thus seldom have the same text.
        """
        waiting = [text.text_id for text in self._handlers.store.texts.all(collection.name, IN_REVIEW)]

        def place(text_id: str) -> bytes:
            return hashlib.sha256(f"{host.worker_id} {text_id}".encode()).digest()

        return min((text_id for text_id in waiting if text_id != but), key=place, default="")


def _version(fields: Mapping[str, str]) -> int:
    text = fields.get("version", "")
    if not (text.isascii() and text.isdecimal() and len(text) < 9):
        raise BadInput(f"version is {quoted(text)}, expected the number of the version that was reviewed")
    return int(text)
