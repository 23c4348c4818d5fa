"""Paid calls of one run: within its limits, traced before they are used, and never repeated."""

import asyncio
from collections.abc import Callable

from arramon_agents.vlm.endpoint import Endpoint, FailedCallError
from arramon_agents.vlm.messages import Conversation
from arramon_agents.vlm.records import (
    Key,
    PaidReplies,
    PaidReply,
    call_record,
    failed_attempts,
    failure_record,
    paid_reply,
)
from arramon_agents.vlm.replies import Reply, UnusableReplyError
from arramon_agents.vlm.settings import ModelSettings
from arramon_agents.vlm.trace import CallTrace
from arramon_agents.vlm.usage import ModelUsage, Price

Read = Callable[[Reply], object]
"""Reads a reply, or raises an UnusableReplyError."""

LAST_WAIT = 10.0
"""Seconds for which `close` waits for open calls, whose answers are paid and kept in the trace."""


class EndpointCaller:
    """The calls of one run.

    Args:
        settings: the agent's settings.
        key: the endpoint's key.
        price: prices of the model; None if unknown.
        trace: the run's open trace.

    Attributes:
        trace: the run's trace.
        paid: replies that were paid for, by this process or earlier ones.
        usage: what the whole run has used, earlier processes included.
    """

    def __init__(self, settings: ModelSettings, key: str, price: Price | None, trace: CallTrace) -> None:
        self.trace = trace
        self.paid = PaidReplies(trace.records)
        self.usage = ModelUsage(settings, price)
        for record in trace.records:
            self.usage.attempts += failed_attempts(record)
            paid = paid_reply(record)
            if paid is not None:
                self.usage.add(paid.tokens, paid.attempts, paid.seconds)
        self._endpoint = Endpoint(settings, key)
        self._open: set[asyncio.Task[PaidReply]] = set()
        self._first = asyncio.Lock()

    async def ask(
        self, purpose: str, episode_id: str, step: int, conversation: Conversation, read: Read | None
    ) -> PaidReply:
        """Return the reply to a conversation: the one that was paid for, or else a new one.

        If the caller is cancelled, the call goes on, and its answer is kept for the next time.

        Args:
            purpose: "act", "again" or "sight".
            episode_id: the episode; empty for the sight check.
            step: the step before which it is asked.
            conversation: what to send.
            read: reads a reply, to record why it cannot be used; None not to.

        Raises:
            StopRun: if a limit is reached, the trace cannot be written, or no call can be answered.
            AgentError: if the call failed for a cause that may pass.
        """
        key = (episode_id, step, conversation.digest)
        known = self.paid.find(*key)
        if known is not None:
            return known
        if self.usage.is_unmeasured:  # Otherwise many first calls could exceed a limit together.
            async with self._first:
                return await self._pay(purpose, key, conversation, read)
        return await self._pay(purpose, key, conversation, read)

    async def _pay(self, purpose: str, key: Key, conversation: Conversation, read: Read | None) -> PaidReply:
        self.trace.check()
        self.usage.reserve()
        call = asyncio.create_task(self._call(purpose, key, conversation, read))
        self._open.add(call)
        call.add_done_callback(self._open.discard)
        return await asyncio.shield(call)

    async def close(self) -> None:
        """Wait for open calls, and close the trace and the connections."""
        if self._open:
            _, late = await asyncio.wait(self._open, timeout=LAST_WAIT)
            for call in late:
                call.cancel()
            await asyncio.gather(*late, return_exceptions=True)
        self.trace.close()
        await self._endpoint.close()

    async def _call(self, purpose: str, key: Key, conversation: Conversation, read: Read | None) -> PaidReply:
        try:
            completion = await self._endpoint.call(conversation.request)
        except FailedCallError as failed:
            self.usage.attempts += len(failed.failures)
            self.trace.write(failure_record(purpose, key, conversation, failed))
            raise failed.error from None
        finally:
            self.usage.release()
        attempts = len(completion.failures) + 1
        self.usage.add(completion.tokens, attempts, completion.seconds)
        paid = PaidReply(key[2], completion.reply, completion.tokens, attempts, completion.seconds)
        self.paid.add(key[0], key[1], paid)
        self.trace.write(call_record(purpose, key, conversation, completion, _cause(completion.reply, read)))
        return paid


def _cause(reply: Reply, read: Read | None) -> str:
    """Return why a reply cannot be used; empty if it can."""
    if read is None:
        return ""
    try:
        read(reply)
    except UnusableReplyError as error:
        return error.cause
    return ""
