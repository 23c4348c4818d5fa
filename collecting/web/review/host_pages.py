"""The host's pages of workers, who can be paused and blocked, and of money, with the ledger as CSV."""

import csv
import io
from collections import Counter
from collections.abc import Sequence
from typing import Any

from aiohttp import web

from arramon_collecting.review.figures import WorkerFigures, figures_of_workers
from arramon_collecting.settings import decimal_amount
from arramon_collecting.storage.payments.records import LedgerEntry
from arramon_collecting.storage.people.records import ACTIVE, BLOCKED, HOST, LEFT, WORKER, WORKER_PAUSED, Worker
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.texts.records import KEPT
from arramon_collecting.web.handlers import BASE, Handlers, request_texts, see_other
from arramon_collecting.web.review.host_view import CollectionRows, collection_address, common, minutes, percent, score
from arramon_collecting.web.review.one_worker import worker_context
from arramon_server.errors import BadInput, NotFound, quoted
from arramon_server.web.http_responses import respond
from arramon_server.web.page_texts import PageTexts

CHANGES = {ACTIVE: (WORKER_PAUSED, BLOCKED), WORKER_PAUSED: (ACTIVE, BLOCKED), BLOCKED: (ACTIVE,), LEFT: (BLOCKED,)}
"""States to which a host may set a worker, by the present state."""

CSV_COLUMNS = ("entry", "worker", "external_id", "kind", "subject", "amount", "currency", "created_at")


ONE = f"{BASE}/workers/{{worker:[0-9a-f]{{32}}}}"
"""Address of one worker's page."""


class HostPages:
    """The pages, for hosts only.

    Args:
        handlers: what all pages of collections share.
    """

    def __init__(self, handlers: Handlers) -> None:
        self._handlers = handlers

    def routes(self) -> list[web.RouteDef]:
        """Return the routes."""
        guarded = self._handlers.guarded
        return [
            web.get(f"{BASE}/workers", guarded(self._workers)),
            web.get(ONE, guarded(self._worker)),
            web.post(f"{ONE}/state", guarded(self._set_state)),
            web.get(f"{BASE}/ledger", guarded(self._ledger)),
            web.get(f"{BASE}/ledger.csv", guarded(self._ledger_file)),
        ]

    def close(self) -> None:
        """Do nothing: there is nothing to end."""

    async def _workers(self, request: web.Request) -> web.StreamResponse:
        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request, host=True)
            store, t = self._handlers.store, request_texts(request)
            rows = CollectionRows.read(store, collection)
            people = store.workers.all(collection.name)
            workers = [worker for worker in people if worker.role == WORKER]
            figures = figures_of_workers(
                workers, rows.tasks, rows.texts, rows.verifications, rows.ledger, collection.settings
            )
            context = common(request, "workers") | {
                "rows": [_worker_row(t, collection, one) for one in figures],
                "hosts": [worker for worker in people if worker.role == HOST],
            }
            return self._handlers.page(request, "collect/workers.html", collection, context, visitor=visitor)

        return await self._handlers.run(make)

    async def _worker(self, request: web.Request) -> web.StreamResponse:
        """Show one worker's texts and verifications, with links to them."""

        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request, host=True)
            person = self._find(request, collection)
            rows = CollectionRows.read(self._handlers.store, collection)
            context = worker_context(collection, person, rows)
            shown = common(request, "") | context | {"choices": CHANGES.get(person.state, ())}
            return self._handlers.page(request, "collect/one_worker.html", collection, shown, visitor=visitor)

        return await self._handlers.run(make)

    def _find(self, request: web.Request, collection: Collection) -> Worker:
        worker = self._handlers.store.workers.get(request.match_info["worker"])
        if worker.collection != collection.name or worker.role != WORKER:
            raise NotFound("there is no such worker in this collection")
        return worker

    async def _set_state(self, request: web.Request) -> web.StreamResponse:
        fields = await self._handlers.form(request)

        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request, host=True)
            self._handlers.check(request, visitor, fields)
            workers, state = self._handlers.store.workers, fields.get("state", "")
            worker = self._find(request, collection)
            allowed = CHANGES.get(worker.state, ())
            if state not in allowed:
                raise BadInput(f"the state is {quoted(state)}, expected {' or '.join(allowed) or 'no change'}")
            workers.set_state(worker.worker_id, state)
            if state == BLOCKED:
                self._handlers.store.sign_ins.close(worker.worker_id)
            return see_other(f"{collection_address(request)}/workers?changed={state}")

        return await self._handlers.run(make)

    async def _ledger(self, request: web.Request) -> web.StreamResponse:
        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request, host=True)
            entries = self._handlers.store.ledger.entries(collection.name)
            context = common(request, "ledger") | _ledger_context(collection, entries)
            return self._handlers.page(request, "collect/ledger.html", collection, context, visitor=visitor)

        return await self._handlers.run(make)

    async def _ledger_file(self, request: web.Request) -> web.StreamResponse:
        def make() -> web.Response:
            collection, _ = self._handlers.visitor(request, host=True)
            entries = self._handlers.store.ledger.entries(collection.name)
            external = {
                one.worker_id: one.external_id or "" for one in self._handlers.store.workers.all(collection.name)
            }
            body = ledger_csv(collection, entries, external).encode()
            return respond(request, body, "text/csv", cache="no-store", name=f"{collection.name}-ledger.csv")

        return await self._handlers.run(make)


def ledger_csv(collection: Collection, entries: Sequence[LedgerEntry], external_ids: dict[str, str]) -> str:
    """Return the ledger as CSV, with amounts in the currency's main unit.

    Args:
        collection: the collection.
        entries: its entries.
        external_ids: ids of a crowd platform by worker; empty texts for those who have none.
    """
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(CSV_COLUMNS)
    digits = collection.settings.currency_digits
    for entry in entries:
        writer.writerow(
            [
                entry.entry_id,
                entry.worker_id,
                _as_text(external_ids.get(entry.worker_id, "")),
                entry.kind,
                entry.subject,
                decimal_amount(entry.amount_minor, digits),
                entry.currency,
                entry.created_at.isoformat(),
            ]
        )
    return file.getvalue()


def _as_text(value: str) -> str:
    """Return a stranger's text so that a spreadsheet takes it for text, not for a formula."""
    return f"'{value}" if value[:1] in ("=", "+", "-", "@", "\t", "\r") else value


def _worker_row(t: PageTexts, collection: Collection, figures: WorkerFigures) -> dict[str, Any]:
    return {
        "worker": figures.worker,
        "written": sum(figures.texts.values()),
        "kept": figures.texts.get(KEPT, 0),
        "pasted": figures.pasted,
        "verifications": figures.verifications,
        "uncounted": figures.uncounted,
        "success": percent(t, figures.success),
        "golds": f"{t.whole(figures.golds_passed)}/{t.whole(figures.golds)}",
        "path": score(t, figures.agreement.path),
        "cell": percent(t, figures.agreement.cell),
        "flag_rate": percent(t, figures.flag_rate),
        "times": [minutes(t, seconds) for _, seconds in sorted(figures.median_seconds.items())],
        "returned": figures.returned,
        "earned": collection.settings.money(figures.earned),
        "choices": CHANGES.get(figures.worker.state, ()),
    }


def _ledger_context(collection: Collection, entries: Sequence[LedgerEntry]) -> dict[str, Any]:
    kinds = list(dict.fromkeys(entry.kind for entry in entries))
    sums, totals = Counter[tuple[str, str]](), Counter[str]()
    for entry in entries:
        sums[entry.worker_id, entry.kind] += entry.amount_minor
        totals[entry.worker_id] += entry.amount_minor
    money = collection.settings.money
    return {
        "kinds": kinds,
        "people": [
            {
                "worker_id": worker_id,
                "amounts": [money(sums[worker_id, kind]) for kind in kinds],
                "total": money(total),
            }
            for worker_id, total in sorted(totals.items())
        ],
        "total": money(sum(totals.values())),
    }
