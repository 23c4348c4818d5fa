"""Messages of a call: system prompt, the window of earlier exchanges, and the question, with their frames."""

import base64
import hashlib
import io
import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from arramon_agents.vlm.prompt_texts import Prompts
from arramon_agents.vlm.replies import Reply
from arramon_agents.vlm.settings import ModelSettings

LONGEST_QUOTE = 2000
"""Characters of an unusable reply that are quoted when the model is asked again."""

JPEG_QUALITY = 90


@dataclass(frozen=True)
class EncodedFrame:
    """An encoded image.

    Attributes:
        name: such as "EPISODE/12", the frame before step 12 of an episode.
        digest: SHA-256 of the encoded image, 16 hexadecimal digits.
        url: the image as a data URL.
    """

    name: str
    digest: str
    url: str

    def part(self, detail: str) -> dict[str, Any]:
        """Return the image as a part of a message's content."""
        return {"type": "image_url", "image_url": {"url": self.url, "detail": detail}}

    def reference(self, detail: str) -> dict[str, Any]:
        """Return the part for the trace: the image is named, and not embedded."""
        return {"type": "image_url", "image_url": {"frame": self.name, "sha256": self.digest, "detail": detail}}


def encode(rgb: npt.NDArray[np.uint8], name: str, settings: ModelSettings) -> EncodedFrame:
    """Return an image (height, width, 3) in the size and format of the settings."""
    image = Image.fromarray(rgb)
    size = settings.image_size
    if size and image.size != (size, size):
        image = image.resize((size, size), Image.Resampling.LANCZOS)
    buffer = io.BytesIO()
    if settings.image_format == "jpeg":
        image.save(buffer, "JPEG", quality=JPEG_QUALITY)
    else:
        image.save(buffer, "PNG")
    data = buffer.getvalue()
    url = f"data:image/{settings.image_format};base64,{base64.b64encode(data).decode()}"
    return EncodedFrame(name, hashlib.sha256(data).hexdigest()[:16], url)


@dataclass
class ModelExchange:
    """One question to the model, and its answer.

    Attributes:
        text: of the question.
        rgb: the frame shown; None without images.
        name: the frame's name.
        reply: the answer; None while the question is open.
        frame: the encoded frame, once it has been sent.
    """

    text: str
    rgb: npt.NDArray[np.uint8] | None
    name: str
    reply: Reply | None = None
    frame: EncodedFrame | None = None


@dataclass(frozen=True)
class Conversation:
    """Messages to send.

    Attributes:
        sent: as the endpoint gets them.
        traced: as the trace keeps them, with frames by name and not embedded.
        form: fields of the request besides the messages; see `replies.answer_form`.
    """

    sent: tuple[dict[str, Any], ...]
    traced: tuple[dict[str, Any], ...]
    form: dict[str, Any]

    @property
    def request(self) -> dict[str, Any]:
        """Fields of the request."""
        return {"messages": list(self.sent), **self.form}

    @property
    def digest(self) -> str:
        """Hash of messages, frames and form, 16 hexadecimal digits."""
        content = json.dumps([self.traced, self.form], sort_keys=True, ensure_ascii=False)
        return hashlib.sha256(content.encode("utf-8", "replace")).hexdigest()[:16]

    def again(self, reply: Reply, prompts: Prompts, cause: str, plan: int) -> "Conversation":
        """Return the conversation that asks again after an unusable reply."""
        reason = prompts.text(f"unusable.{cause}", **({"plan": plan} if cause == "fields" else {}))
        said = reply.text or " ".join(arguments for _, arguments in reply.calls) or "-"
        added = (
            {"role": "assistant", "content": said[:LONGEST_QUOTE]},
            {"role": "user", "content": prompts.text("unusable.again", reason=reason)},
        )
        return replace(self, sent=self.sent + added, traced=self.traced + added)


class ConversationWriter:
    """Writer of conversations by the settings.

    Args:
        settings: the agent's settings.
    """

    def __init__(self, settings: ModelSettings) -> None:
        self._settings = settings

    def conversation(
        self, system: str, exchanges: Iterable[ModelExchange], question: ModelExchange, form: dict[str, Any]
    ) -> Conversation:
        """Return the conversation of a system prompt, earlier exchanges, and a question."""
        sent: list[dict[str, Any]] = [{"role": "system", "content": system}]
        traced = list(sent)
        for exchange in (*exchanges, question):
            frame = self._frame(exchange)
            sent.append(self._user(exchange.text, frame.part(self._settings.detail) if frame else None))
            traced.append(self._user(exchange.text, frame.reference(self._settings.detail) if frame else None))
            if exchange.reply is not None:
                said = _answer(exchange.reply, self._settings.answers)
                sent += said
                traced += said
        return Conversation(tuple(sent), tuple(traced), form)

    def _frame(self, exchange: ModelExchange) -> EncodedFrame | None:
        if exchange.frame is None and exchange.rgb is not None:
            exchange.frame, exchange.rgb = encode(exchange.rgb, exchange.name, self._settings), None
        return exchange.frame

    def _user(self, text: str, image: dict[str, Any] | None) -> dict[str, Any]:
        content: Any = text if image is None else [{"type": "text", "text": text}, image]
        return {"role": "user", "content": content}


def _answer(reply: Reply, answers: str) -> list[dict[str, Any]]:
    """Return a usable reply as messages of the history."""
    if answers != "tools":
        return [{"role": "assistant", "content": reply.text}]
    (name, arguments), call_id = reply.calls[0], reply.call_ids[0]
    call = {"id": call_id, "type": "function", "function": {"name": name, "arguments": arguments}}
    return [
        {"role": "assistant", "content": None, "tool_calls": [call]},
        {"role": "tool", "tool_call_id": call_id, "content": "ok"},
    ]
