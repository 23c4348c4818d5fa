"""The sight check: the model names what a drawn card shows, through the route on which it will play."""

import random
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from arramon_agents.vlm.prompt_texts import Prompts
from arramon_agents.vlm.replies import Reply, UnusableReplyError, read_fields

CARDS = 2
"""Cards that are shown at most; the model must name one of them rightly. Guesses from the lists below succeed once in
240 runs."""

TOOL = "name"
"""Name of the schema, and of the tool with `answers=tools`."""

COLOURS = {
    "red": (210, 30, 30), "green": (20, 150, 40), "blue": (30, 60, 210), "yellow": (235, 200, 0),
    "purple": (130, 30, 160), "black": (0, 0, 0),
}  # fmt: skip

SHAPES = ("circle", "square", "triangle", "star")

WORDS = (
    "APPLE", "BRIDGE", "CANDLE", "DESERT", "ENGINE", "FOREST", "GARDEN", "HAMMER", "ISLAND", "JACKET", "KETTLE",
    "LADDER", "MARKET", "NEEDLE", "ORANGE", "PENCIL", "RABBIT", "SILVER", "TEMPLE", "WINDOW",
)  # fmt: skip

SIZE = 224
"""Side length of the card in pixels, that of the server's frames by default."""


@dataclass(frozen=True)
class Card:
    """What a card shows."""

    shape: str
    colour: str
    word: str

    def is_named_by(self, reply: Reply, tool: str | None) -> bool:
        """Return whether a reply names the shape, the colour and the word, in any case of letters.

        Args:
            reply: the reply.
            tool: name of the tool that it must call; None if its content must be JSON.
        """
        try:
            fields = read_fields(reply, tool)
        except UnusableReplyError:
            return False
        named = tuple(str(fields.get(name, "")).strip().lower() for name in ("shape", "colour", "word"))
        return named == (self.shape, self.colour, self.word.lower())


def draw_card(source: random.Random) -> Card:
    """Return a random card."""
    return Card(source.choice(SHAPES), source.choice([*COLOURS]), source.choice(WORDS))


def picture(card: Card) -> npt.NDArray[np.uint8]:
    """Return a card as an image (SIZE, SIZE, 3)."""
    image = Image.new("RGB", (SIZE, SIZE), (245, 245, 240))
    draw = ImageDraw.Draw(image)
    draw.polygon(_outline(card.shape), fill=COLOURS[card.colour])
    draw.text((SIZE / 2, SIZE * 0.82), card.word, fill=(20, 20, 20), font=ImageFont.load_default(34), anchor="mm")
    return np.asarray(image)


def question(prompts: Prompts, answers: str) -> str:
    """Return the question, which says in which form to answer."""
    lines = [
        prompts.text("sight.question"),
        prompts.text("sight.tools" if answers == "tools" else "sight.json"),
        prompts.text("sight.shapes", shapes=", ".join(SHAPES)),
        prompts.text("sight.colours", colours=", ".join(COLOURS)),
        prompts.text("sight.word"),
    ]
    return "\n".join(lines)


def schema() -> dict[str, Any]:
    """Return the JSON Schema of an answer."""
    texts = {name: {"type": "string"} for name in ("shape", "colour", "word")}
    return {"type": "object", "properties": texts, "required": [*texts], "additionalProperties": False}


def _outline(shape: str) -> list[tuple[float, float]]:
    """Return the corners of a shape, in pixels."""
    corners, radius = {"circle": 72, "square": 4, "triangle": 3, "star": 10}[shape], SIZE * 0.3
    start = 45.0 if shape == "square" else 0.0
    angles = np.radians(start + np.arange(corners) * 360.0 / corners)
    radii = np.where(np.arange(corners) % 2, radius * 0.4, radius) if shape == "star" else np.full(corners, radius)
    across, down = SIZE / 2 + radii * np.sin(angles), SIZE * 0.38 - radii * np.cos(angles)
    return [(float(x), float(y)) for x, y in zip(across, down, strict=True)]
