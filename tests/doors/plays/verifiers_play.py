"""Plays by `Env.run_episode` with a harness that makes one call, and an endpoint that answers by the script."""

import asyncio
import json
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import httpx
import verifiers.v1 as vf
from script import ADDRESS, EPISODE, LANGUAGE, plan, step_of, write
from verifiers.v1.dialects.chat import message_to_wire

from arramon_client.adapters.verifiers import load_environment

__all__ = ["OneCall"]


class Endpoint(BaseHTTPRequestHandler):
    """An endpoint of chat completions."""

    protocol_version = "HTTP/1.1"

    def log_message(self, *_: object) -> None:
        """Log nothing."""

    def do_POST(self) -> None:
        """Answer with the next actions of the script; once with prose."""
        messages = json.loads(self.rfile.read(int(self.headers["content-length"])))["messages"]
        kinds = [part["type"] for part in messages[-1]["content"]]
        assert kinds == ["text", "image_url"], kinds
        text = messages[-1]["content"][0]["text"]
        content = json.dumps({"actions": plan(step_of(text))}) if len(messages) > 2 else "I go forward."
        choice = {"index": 0, "finish_reason": "stop", "message": {"role": "assistant", "content": content}}
        usage = {"prompt_tokens": 1, "completion_tokens": 1, "total_tokens": 2}
        answer = {
            "id": "1",
            "object": "chat.completion",
            "created": 0,
            "model": "m",
            "choices": [choice],
            "usage": usage,
        }
        body = json.dumps(answer | {"choices": [choice], "usage": usage}).encode()
        self.send_response(200)
        self.send_header("content-type", "application/json")
        self.send_header("content-length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)


class OneCall(vf.Harness[vf.HarnessConfig]):
    """A harness that sends the conversation, in this process: those of verifiers download packages for each program."""

    APPENDS_SYSTEM_PROMPT = SUPPORTS_RESUME = True
    EXECUTES_CODE = NEEDS_CONTAINER = False

    async def launch(self, ctx, trace, runtime, endpoint, secret, mcp_urls, data):
        """Make one call."""
        system, prompt = self.resolve_prompt(data)
        messages = [{"role": "system", "content": system}, *map(message_to_wire, prompt)]
        async with httpx.AsyncClient() as client:
            answer = await client.post(
                f"{endpoint}/chat/completions",
                json={"model": ctx.model, "messages": messages},
                headers={"Authorization": f"Bearer {secret}"},
            )
        answer.raise_for_status()
        return vf.ProgramResult(0, "", "")


async def main() -> None:
    """Play the episode."""
    endpoint = ThreadingHTTPServer(("127.0.0.1", 0), Endpoint)
    threading.Thread(target=endpoint.serve_forever, daemon=True).start()
    player = {"harness": {"id": "verifiers_play"}, "runtime": {"type": "subprocess"}}
    env = load_environment(lang=LANGUAGE, split="tiny", server=ADDRESS, player=player)
    address = f"http://127.0.0.1:{endpoint.server_port}/v1"
    ctx = vf.ModelContext(model="m", client=vf.EvalClientConfig(base_url=address, api_key_var="UNSET"))
    async with env.serving():
        (task,) = env.taskset.include(ids=[EPISODE])
        assert task.data.section == "1"
        episode = await env.run_episode(task, ctx)
    assert episode.ok, episode.errors
    (trace,) = episode.traces
    write({**trace.info["arramon"], "headline": {name: reward.score for name, reward in trace.rewards.items()}})


if __name__ == "__main__":
    asyncio.run(main())
