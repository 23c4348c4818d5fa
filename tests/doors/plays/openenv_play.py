"""Plays by the environment's client over its web server; the connection is lost before acts, which are sent twice."""

import asyncio
import os
import threading

import uvicorn
from script import ADDRESS, EPISODE, LANGUAGE, plan, write

os.environ |= {"ARRAMON_SERVER": ADDRESS, "ARRAMON_SPLIT": "tiny"}

from arramon_client.adapters.openenv.app import make_app
from arramon_client.adapters.openenv.client import ArramonEnv
from arramon_client.adapters.openenv.messages import ArramonAction

server = uvicorn.Server(uvicorn.Config(make_app(), port=0, log_level="critical"))


async def main() -> None:
    """Play the episode."""
    threading.Thread(target=server.run, daemon=True).start()
    while not server.started:
        await asyncio.sleep(0.05)
    port = server.servers[0].sockets[0].getsockname()[1]
    async with ArramonEnv(base_url=f"http://127.0.0.1:{port}") as env:
        result = await env.reset(lang=LANGUAGE, episode_id=EPISODE)
        assert result.observation.image.startswith("data:image/png;base64,")
        while not result.done:
            step = result.observation.step
            action = ArramonAction(step=step, actions=plan(step))
            if step < 6:
                await env._ws.close()
            result = await env.step(action)
            again = await env.step(action)
            assert again.observation.model_dump(exclude={"stop_reason"}) == result.observation.model_dump(
                exclude={"stop_reason"}
            )
            state = await env.state()
            assert (state.episode_id, state.language, state.done) == (EPISODE, LANGUAGE, result.done)
        write({**result.observation.result, "reward": result.reward})
        await play_hidden(env)


async def play_hidden(env: ArramonEnv) -> None:
    """Play a hidden split of two episodes: one run, in its order, with scores when the last has ended."""
    refused = ""
    try:
        await env.reset(lang="en", split="secret", seed=1)
    except RuntimeError as error:
        refused = str(error)
    assert "the hidden split 'secret' is played in its own order" in refused
    results = []
    for _ in range(2):
        result = await env.reset(lang="en", split="secret")
        while not result.done:
            step = result.observation.step
            result = await env.step(ArramonAction(step=step, actions=plan(step)))
        assert result.reward is None
        results.append(result.observation.result)
    first, last = results
    assert first["run_id"] == last["run_id"]
    assert first["episode_id"] != last["episode_id"]
    assert ("run_scores" in first, sorted(last["run_scores"])) == (False, ["total", "turn 1", "turn 2"])


asyncio.run(main())
