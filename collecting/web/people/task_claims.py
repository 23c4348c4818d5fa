"""Where a worker who asks for a task goes: to the task, or to what is missing before it."""

from collections.abc import Mapping
from dataclasses import replace

from aiohttp import web

from arramon_collecting.episodes import episodes_to_write, golds
from arramon_collecting.rules.next_step import Step, next_step
from arramon_collecting.storage.people.records import ACTIVE, LEFT, Worker
from arramon_collecting.storage.people.workers import check_active
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.work.records import VERIFY, WRITE, Task
from arramon_collecting.web.handlers import home_address
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput, NotFound, quoted


class TaskClaims:
    """Gives out tasks.

    Args:
        store: storage of the collections.
        splits: the served splits, by name.
    """

    def __init__(self, store: Store, splits: Mapping[str, Split]) -> None:
        self._store = store
        self._splits = splits

    def address(
        self, request: web.Request, collection: Collection, worker: Worker, stage: str, *, text_id: str = ""
    ) -> str | None:
        """Return the address of a new task or of the next test before it; None if there is no task for the worker.

        Args:
            request: the request, whose language and collection are those of the address.
            collection: the collection.
            worker: who asks; one who has left comes back by that.
            stage: "write" or "verify".
            text_id: a text that was sent back to the worker, to correct it; empty for a new task.

        Raises:
            BadInput: if the worker does not work in the stage.
            Forbidden: if the worker or the collection is paused.
        """
        if stage not in (WRITE, VERIFY) or stage not in worker.stages:
            raise BadInput(f"the stage is {quoted(stage)}, expected {' or '.join(worker.stages)}")
        home, step = home_address(request), step_before(worker, stage)
        if step is Step.CONSENT:
            return home
        if worker.state == LEFT:
            self._store.workers.set_state(worker.worker_id, ACTIVE)
            worker = replace(worker, state=ACTIVE)
        check_active(worker)
        if step is not Step.TASK:
            return home + {Step.DEVICE: f"{step}?stage={stage}", Step.SCREENING: f"{step}/{stage}"}.get(step, str(step))
        task = self._claim(collection, worker, stage, text_id)
        return f"{home}{stage}/{task.task_id}" if task else None

    def _claim(self, collection: Collection, worker: Worker, stage: str, text_id: str) -> Task | None:
        tasks, split = self._store.tasks, self._splits.get(collection.split)
        if split is None:
            raise NotFound(f"the split {collection.split!r} of this collection is not served")
        if stage == VERIFY:
            return tasks.claim_verify(collection, worker, golds(split, collection))
        if text_id:
            return tasks.claim_mend(collection, worker, text_id)
        return tasks.claim_write(collection, worker, episodes_to_write(split, collection))


def step_before(worker: Worker, stage: str) -> Step:
    """Return what a worker has to do before a task of a stage."""
    return next_step(
        stage,
        consented=worker.consented_at is not None,
        device=worker.device,
        screening=worker.screening,
        placement_passed=worker.placement_passed_at is not None,
    )
