"""A fake OpenAI-compatible endpoint, which counts calls and tokens, and answers as a function says.

It counts a token for every 4 characters of text, and IMAGE_TOKENS for an image, so that figures are comparable and
nobody's tokenizer is needed.

    python -m benchmarks.agents.fake_endpoint [--port PORT]

serves one in place of a model, to try `agents.vlm` without one: it passes the sight check, and walks without reading.
"""

import argparse
import base64
import io
import json
import re
import socket
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from arramon_agents.vlm import sight

IMAGE_TOKENS = 85
"""Tokens of an image, the number of several models for `detail=low`."""

ACTIONS = ("forward", "left", "right", "interact")
"""Names of the actions, by number."""

PATH = "/v1/chat/completions"
"""The only path that is answered, as with a real server."""

Request = Mapping[str, Any]


@dataclass(frozen=True)
class Response:
    """A response of the endpoint.

    Attributes:
        body: of the response.
        status: HTTP status.
        headers: further headers.
        delay: seconds before it is sent.
        closes: whether the connection is closed in place of a response.
        cut: whether only half of the body is sent before the connection is closed.
    """

    body: bytes = b""
    status: int = 200
    headers: Mapping[str, str] = field(default_factory=dict)
    delay: float = 0.0
    closes: bool = False
    cut: bool = False


Behaviour = Callable[[Request, int], Response]
"""Answers a request; the number counts requests from 0."""


class FakeEndpoint:
    """The endpoint, on a free port, while the context lasts.

    Args:
        behaviour: answers the requests.
        port: 0 for a free one.

    Attributes:
        requests: bodies of all requests, in order of arrival.
        keys: the Authorization headers.
        most_open: the most requests that were open at the same time.
    """

    def __init__(self, behaviour: Behaviour, port: int = 0) -> None:
        self.behaviour = behaviour
        self.requests: list[Request] = []
        self.keys: list[str] = []
        self.open = self.most_open = 0
        self._lock = threading.Lock()
        self._server = _Server(("127.0.0.1", port), _handler_of(self))
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.05,), daemon=True)

    @property
    def url(self) -> str:
        """Base URL of the endpoint."""
        return f"http://127.0.0.1:{self._server.server_address[1]}/v1"

    def __enter__(self) -> "FakeEndpoint":
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def answer(self, body: bytes, key: str) -> Response:
        """Return the response to a request."""
        request = json.loads(body)
        with self._lock:
            number = len(self.requests)
            self.requests.append(request)
            self.keys.append(key)
            self.open += 1
            self.most_open = max(self.open, self.most_open)
            response = self.behaviour(request, number)
        time.sleep(response.delay)
        with self._lock:
            self.open -= 1
        return response


def completion(
    request: Request,
    text: str | None,
    *,
    finish: str = "stop",
    tools: Sequence[tuple[str, str]] = (),
    refusal: str | None = None,
    usage: bool = True,
    delay: float = 0.0,
) -> Response:
    """Return a chat completion.

    Args:
        request: the request, whose tokens are counted.
        text: the message's content.
        finish: the finish reason.
        tools: names and arguments of called tools.
        refusal: the refusal's text.
        usage: whether tokens are reported.
        delay: seconds before the response.
    """
    message: dict[str, Any] = {"role": "assistant", "content": text}
    if refusal is not None:
        message["refusal"] = refusal
    if tools:
        message["tool_calls"] = [
            {"id": f"call_{index}", "type": "function", "function": {"name": name, "arguments": arguments}}
            for index, (name, arguments) in enumerate(tools)
        ]
    content: dict[str, Any] = {
        "id": "fake", "object": "chat.completion", "created": 0, "model": "fake-1",
        "choices": [{"index": 0, "message": message, "finish_reason": finish}],
    }  # fmt: skip
    if usage:
        read, wrote = prompt_tokens(request), _tokens((text or "") + "".join(arguments for _, arguments in tools))
        content["usage"] = {
            "prompt_tokens": read,
            "completion_tokens": wrote,
            "total_tokens": read + wrote,
            "prompt_tokens_details": {"cached_tokens": min(read, _tokens(system_of(request)))},
        }
    return Response(json.dumps(content).encode(), delay=delay)


def error(status: int, message: str, code: str = "", headers: Mapping[str, str] | None = None) -> Response:
    """Return an error in the form of OpenAI's."""
    content = {"error": {"message": message, "type": "error", "param": None, "code": code or None}}
    return Response(json.dumps(content).encode(), status, headers or {})


def plan(request: Request, actions: Sequence[str], thought: str = "I go on.") -> Response:
    """Return an answer with a plan, by JSON or by a call of the tool, as the request asks."""
    text = json.dumps({"thought": thought, "actions": list(actions)})
    return completion(request, None, tools=[("act", text)]) if "tools" in request else completion(request, text)


def walk(request: Request, number: int) -> Response:  # noqa: ARG001 - a behaviour
    """Return a plan that does not depend on what the request shows."""
    return name_card(request) if is_sight_check(request) else plan(request, ["forward", "forward", "left"])


class Expert:
    """A behaviour that knows the actions of each instruction, and plans the next ones from the step it reads.

    Args:
        actions: numbers of the actions of a phase, by its instruction.
        most: the most actions of a plan.
        delay: seconds before each response.
    """

    def __init__(self, actions: Mapping[str, Sequence[int]], most: int, delay: float = 0.0) -> None:
        self._actions = actions
        self._most = most
        self._delay = delay

    def __call__(self, request: Request, number: int) -> Response:  # noqa: ARG002 - a behaviour
        """Return the next actions."""
        if is_sight_check(request):
            return name_card(request)
        instruction = system_of(request).rpartition("\n")[2]
        step = int(STEP.findall(text_of(request["messages"][-1]))[-1])
        actions = self._actions[instruction][step : step + self._most]
        made = plan(request, [ACTIONS[action] for action in actions] or ["right"])
        return Response(made.body, delay=self._delay)


STEP = re.compile(r"(?:Step|क़दम) (\d+)")


def is_sight_check(request: Request) -> bool:
    """Return whether a request shows the card of the sight check."""
    return '"word"' in text_of(request["messages"][-1])


def name_card(request: Request) -> Response:
    """Return the answer of a model that sees to the sight check."""
    image = image_of(request["messages"][-1])
    shown = np.asarray(Image.fromarray(image).resize((sight.SIZE, sight.SIZE))).astype(int)

    def distance(card: sight.Card) -> float:
        return float(np.abs(sight.picture(card).astype(int) - shown).mean())

    looks = [sight.Card(shape, colour, "") for shape in sight.SHAPES for colour in sight.COLOURS]
    look = min(looks, key=distance)
    words = [sight.Card(look.shape, look.colour, word) for word in sight.WORDS]
    card = min(words, key=distance)
    text = json.dumps({"shape": card.shape, "colour": card.colour, "word": card.word})
    return completion(request, None, tools=[(sight.TOOL, text)]) if "tools" in request else completion(request, text)


def image_of(message: Mapping[str, Any]) -> npt.NDArray[np.uint8]:
    """Return the image in a message.

    Raises:
        StopIteration: if there is none.
    """
    url = next(part["image_url"]["url"] for part in message["content"] if part["type"] == "image_url")
    data = base64.b64decode(url.partition(",")[2])
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))


def system_of(request: Request) -> str:
    """Return the system prompt."""
    return text_of(request["messages"][0])


def text_of(message: Mapping[str, Any]) -> str:
    """Return the text of a message."""
    content = message.get("content") or ""
    return content if isinstance(content, str) else "".join(part.get("text", "") for part in content)


def prompt_tokens(request: Request) -> int:
    """Return the number of tokens of a request's messages."""
    total = 0
    for message in request["messages"]:
        content = message.get("content")
        parts = content if isinstance(content, list) else []
        total += _tokens(text_of(message)) + IMAGE_TOKENS * sum(part["type"] == "image_url" for part in parts)
    return total


def _tokens(text: str) -> int:
    return -(-len(text) // 4)


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    request_queue_size = 128

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore clients that have gone: they are killed in tests."""


def _handler_of(endpoint: FakeEndpoint) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_POST(self) -> None:
            """Answer a request."""
            body = self.rfile.read(int(self.headers["Content-Length"]))
            if self.path == PATH:
                response = endpoint.answer(body, self.headers.get("Authorization", ""))
            else:
                response = error(404, f"there is nothing at {self.path}, only at {PATH}")
            if response.closes:
                self.close_connection = True
                with suppress(OSError):
                    self.connection.shutdown(socket.SHUT_RDWR)
                return
            self.send_response(response.status)
            for name, value in {"Content-Type": "application/json", **response.headers}.items():
                self.send_header(name, value)
            self.send_header("Content-Length", str(len(response.body)))
            self.end_headers()
            self.wfile.write(response.body[: len(response.body) // 2] if response.cut else response.body)
            self.wfile.flush()
            self.close_connection = self.close_connection or response.cut

        def log_message(self, format: str, *args: Any) -> None:  # noqa: A002 - the base class's name
            """Say nothing."""

    return Handler


def main() -> None:
    """Serve an endpoint that walks without reading, until the command is interrupted."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--port", type=int, default=8000, help="port on this machine; 0 for a free one")
    with FakeEndpoint(walk, parser.parse_args().port) as endpoint:
        print(f"listening on {endpoint.url}", flush=True)
        with suppress(KeyboardInterrupt):
            threading.Event().wait()


if __name__ == "__main__":
    main()
