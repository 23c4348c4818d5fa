"""The client: an `EnvClient` that goes on with its episode when the connection is lost."""

import asyncio
from typing import Any

from arramon_client.adapters.extras import extra
from arramon_client.adapters.openenv.messages import ArramonAction, ArramonObservation, ArramonState

with extra("openenv"):
    from openenv.core.client_types import StepResult
    from openenv.core.env_client import EnvClient
    from websockets.exceptions import ConnectionClosed

DELAYS = (0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 15.0, 30.0)
"""Seconds between attempts to reconnect."""


class ArramonEnv(EnvClient[ArramonAction, ArramonObservation, ArramonState]):
    """Client of an ArraMon environment:

        async with ArramonEnv(base_url="http://localhost:8000") as env:
            result = await env.reset(lang="hi", seed=3)
            while not result.done:
                step = result.observation.step
                result = await env.step(ArramonAction(step=step, actions=["forward"]))
            print(result.observation.result)

    Use `ArramonEnv(...).sync()` without an event loop. When the connection is lost, the client opens another one, goes
    on with the run, and repeats the step, which is taken once.

    Raises:
        ConnectionError: by all methods, if the server stays away for a minute.
        RuntimeError: if the server refuses what was sent; the message says why.
    """

    _run_id = ""

    async def _send_and_receive(self, message: dict[str, Any]) -> dict[str, Any]:
        try:
            response: dict[str, Any] = await super()._send_and_receive(message)
        except (ConnectionClosed, OSError) as error:
            response = await self._resume(message, error)
        observation = response.get("data", {}).get("observation") or {}
        self._run_id = observation.get("run_id") or self._run_id
        return response

    async def _resume(self, message: dict[str, Any], error: Exception) -> dict[str, Any]:
        """Reconnect, take up the run, and send a message again."""
        for delay in DELAYS:
            await asyncio.sleep(delay)
            self._ws = None
            try:
                if self._run_id and message["type"] != "reset":
                    await super()._send_and_receive({"type": "reset", "data": {"resume": self._run_id}})
                response: dict[str, Any] = await super()._send_and_receive(message)
            except (ConnectionClosed, OSError) as again:
                error = again
            else:
                return response
        raise ConnectionError(f"the environment at {self._ws_url} is away: {error}") from error

    def _step_payload(self, action: ArramonAction) -> dict[str, Any]:
        return {"step": action.step, "actions": action.actions}

    def _parse_result(self, payload: dict[str, Any]) -> StepResult[ArramonObservation]:
        done, reward = payload.get("done", False), payload.get("reward")
        observation = ArramonObservation(**payload["observation"], done=done, reward=reward)
        return StepResult(observation=observation, reward=reward, done=done)

    def _parse_state(self, payload: dict[str, Any]) -> ArramonState:
        return ArramonState(**payload)
