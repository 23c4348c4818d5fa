"""Frames as images of a message: encoded, and named for the trace."""

import base64
import hashlib
import io
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from arramon_agents.vlm.settings import Settings

JPEG_QUALITY = 90


@dataclass(frozen=True)
class Frame:
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


def encode(rgb: npt.NDArray[np.uint8], name: str, settings: Settings) -> Frame:
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
    return Frame(name, hashlib.sha256(data).hexdigest()[:16], url)
