"""Observations as PNG or JPEG images."""

import io
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from PIL import Image

from arramon_client.agent import Observation
from arramon_client.errors import UsageError

FAR = 20.0
"""Depth in metres that is black in an image; the camera's own position would be white."""

JPEG_QUALITY = 90


def picture(observation: Observation, sensor: str, image_format: str, size: int) -> bytes:
    """Return a sensor's image as a file.

    Args:
        observation: the observation.
        sensor: "rgb", or "depth" for shades of grey, the nearer the brighter: white at 0 m, black at FAR and beyond.
        image_format: "png" or "jpeg".
        size: side length in pixels; 0 for that of the observation.

    Raises:
        UsageError: if the observation has no such image.
    """
    depth = observation.depth
    pixels = observation.rgb if sensor == "rgb" else None if depth is None else _shades(depth)
    if pixels is None:
        raise UsageError(f"the observation has no {sensor}: its images can only be those of the run's sensors")
    image = Image.fromarray(pixels)
    if size and image.size != (size, size):
        image = image.resize((size, size), Image.Resampling.BILINEAR)
    file = io.BytesIO()
    image.save(file, image_format, quality=JPEG_QUALITY)
    return file.getvalue()


def chosen_images(wanted: Sequence[str] | None, sensors: Sequence[str]) -> Sequence[str]:
    """Return the images to send, by sensor.

    Args:
        wanted: the sensors that a call names; None for "rgb", if the run has it.
        sensors: the run's sensors.

    Raises:
        UsageError: if the run does not have a sensor that is named.
    """
    if wanted is None:
        return [sensor for sensor in ("rgb",) if sensor in sensors]
    missing = [sensor for sensor in wanted if sensor not in sensors]
    if missing:
        known = ", ".join(sensors) or "none"
        raise UsageError(f"the run has no images of {', '.join(missing)}; its sensors are {known}")
    return wanted


def _shades(depth: npt.NDArray[np.float32]) -> npt.NDArray[np.uint8]:
    near = np.where(depth > 0, 1.0 - depth / FAR, 0.0)
    return (255 * near.clip(0.0, 1.0)).astype(np.uint8)
