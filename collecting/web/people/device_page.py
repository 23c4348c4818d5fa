"""The page that measures a worker's device before the first task."""

from dataclasses import asdict
from typing import Any

from aiohttp import web

from arramon_collecting.rules.device_screening import Device, DeviceProblem, problems_of, read_device
from arramon_collecting.settings import STAGES, DeviceRules
from arramon_collecting.web.access import CSRF_HEADER
from arramon_collecting.web.handlers import BASE, Handlers, home_address, json_response, request_texts
from arramon_server.errors import Conflict
from arramon_server.web.page_texts import PageTexts


class DevicePage:
    """The page and what its script sends.

    Args:
        handlers: what all pages of collections share.
    """

    def __init__(self, handlers: Handlers) -> None:
        self._handlers = handlers

    def routes(self) -> list[web.RouteDef]:
        """Return the routes."""
        guarded = self._handlers.guarded
        return [web.get(f"{BASE}/device", guarded(self._show)), web.post(f"{BASE}/device", guarded(self._take))]

    def close(self) -> None:
        """Do nothing: there is nothing to end."""

    async def _show(self, request: web.Request) -> web.StreamResponse:
        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            t = request_texts(request)
            stage = request.query.get("stage", "")
            context: dict[str, Any] = {
                "stage": stage if stage in visitor.worker.stages else "",
                "next_address": home_address(request),
                "settings": {
                    "address": request.path,
                    "csrf": visitor.csrf,
                    "header": CSRF_HEADER,
                    "texts": {"fit": t("collect_device.fit"), "lost": t("collect_device.lost")},
                },
            }
            return self._handlers.page(request, "collect/device.html", collection, context, visitor=visitor)

        return await self._handlers.run(make)

    async def _take(self, request: web.Request) -> web.StreamResponse:
        content = await self._handlers.json(request)

        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            self._handlers.check(request, visitor)
            if visitor.worker.consented_at is None:
                raise Conflict("nothing is measured before the worker has agreed to the collection's text")
            device, rules = read_device(content), collection.settings.device
            stages = [stage for stage in STAGES if stage in visitor.worker.stages]
            problems = problems_of(device, rules, stages)
            stored = asdict(device) | ({"problems": list(map(str, problems))} if problems else {})
            self._handlers.store.workers.record_device(visitor.worker.worker_id, stored)
            message = _message(request_texts(request), device, rules, problems) if problems else ""
            return json_response({"problems": list(map(str, problems)), "message": message})

        return await self._handlers.run(make)


def _message(t: PageTexts, device: Device, rules: DeviceRules, problems: list[DeviceProblem]) -> str:
    values: dict[DeviceProblem, dict[str, str]] = {
        DeviceProblem.TOO_NARROW: {"found": t.whole(device.width), "needed": t.whole(rules.min_width)},
        DeviceProblem.TOO_SLOW: {"found": t.whole(round(device.frame_ms)), "needed": t.whole(rules.max_frame_ms)},
    }
    said = [t(f"collect_device.{problem}", **values.get(problem, {})) for problem in problems]
    return t("collect_device.unfit", problems=" ".join(said))
