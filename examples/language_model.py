"""An agent that asks a language model for each action: arramon-client --agent ./examples/language_model.py --lang hi

    --agent-arg model=Qwen/Qwen3-VL-8B --agent-arg endpoint=http://localhost:8000/v1

It is the smallest one that works: a frame and an instruction go out, a word comes back. `agents.vlm` does the same with
plans, retries, limits of cost and a trace. The key is read from `OPENAI_API_KEY`; it needs `pip install openai pillow`.
"""

import base64
import io
import os

from openai import AsyncOpenAI
from PIL import Image

from arramon_client import Action, Answer, Episode, Observation

ACTIONS = {
    "forward": Action.FORWARD,
    "left": Action.LEFT,
    "right": Action.RIGHT,
    "interact": Action.INTERACT,
}

TASK = """\
You walk through a city, or a small room, and see one picture at a time. Answer with one word:
forward (a step), left or right (turn by 30 degrees), or interact (in the city: pick up the object of the instruction,
within three steps ahead; in the room: place it on the tile ahead).
The instruction:
"""


class Agent:
    """An agent whose calls wait for the model; the client plays its episodes side by side.

    Args:
        model: name of the model at the endpoint.
        endpoint: base URL of an endpoint that speaks OpenAI's chat completions; OpenAI's own by default.
    """

    sensors = ("rgb",)

    def __init__(self, model: str, endpoint: str | None = None) -> None:
        self._model = model
        self._client = AsyncOpenAI(base_url=endpoint, api_key=os.environ.get("OPENAI_API_KEY", "none"))

    def begin(self, episode: Episode) -> None:
        """Begin an episode; nothing is kept of it, so there is nothing to prepare."""

    async def act(self, observation: Observation) -> Answer:
        """Return the model's action, with its words as a note; a turn where they name no action."""
        reply = await self._client.chat.completions.create(
            model=self._model,
            messages=[
                {"role": "system", "content": TASK + observation.instruction},
                {
                    "role": "user",
                    "content": [
                        {"type": "image_url", "image_url": {"url": as_url(observation)}},
                        {"type": "text", "text": f"Steps left: {observation.steps_left}"},
                    ],
                },
            ],
        )
        said = (reply.choices[0].message.content or "").strip()
        return Answer(ACTIONS.get(said.lower(), Action.RIGHT), note=said[:500])

    async def close(self) -> None:
        """Close the connections."""
        await self._client.close()


def as_url(observation: Observation) -> str:
    """Return the frame as the address of a picture."""
    assert observation.rgb is not None  # as `sensors` names it
    file = io.BytesIO()
    Image.fromarray(observation.rgb).save(file, format="JPEG", quality=90)
    return "data:image/jpeg;base64," + base64.b64encode(file.getvalue()).decode()
