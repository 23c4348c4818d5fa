"""The visual encoder "eyes": one network predicts what each block of a frame shows, another names cut-out things."""

import hashlib
from dataclasses import asdict
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from torch import nn

from arramon_agents.perception.eyes.detected_things import DetectedThing, NamedParts, find_and_name_parts
from arramon_agents.perception.eyes.grid import CHANNEL_NAMES, add_things, grid_of_blocks
from arramon_agents.perception.eyes.naming_network import NamingNetwork
from arramon_agents.perception.eyes.network import (
    EyesNetwork,
    EyesSizes,
    Probabilities,
    prepare,
    prepare_for_inference,
    probabilities,
)
from arramon_agents.perception.eyes.reach import FAR, NEAR, Reach
from arramon_agents.weights import read_weights_file, write_weights_file

WEIGHTS = Path(__file__).with_name("weights.safetensors")
"""Shipped weights of the encoder for single frames, whose features trained agents know."""

FAR_WEIGHTS = WEIGHTS.with_name("far.safetensors")
"""Shipped weights of the encoder for agents that keep a map."""

FORMAT = "eyes 1"

VERSION = "3"
"""Version of the features, increased when the code changes them."""

BATCH = 8
"""Batch size; more frames do not fit into the CPU's caches."""


class Eyes:
    """A `VisualEncoder` that also predicts the content of each block of a frame, and names things on the ground.

    Args:
        blocks, naming: trained networks, in evaluation mode.
        fingerprint: hash of their weights.
        reach: which things are cut out.
    """

    name = "eyes"
    channels = len(CHANNEL_NAMES)
    channel_names = CHANNEL_NAMES

    def __init__(self, blocks: EyesNetwork, naming: NamingNetwork, fingerprint: str, reach: Reach = NEAR) -> None:
        self._blocks, self._naming, self._reach = blocks, naming, reach
        self.image_size = blocks.sizes.image
        self.fingerprint = fingerprint

    def encode(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Return features of each cell, (B, 7, 7, C) float32 in [0, 1].

        Args:
            rgb: (B, size, size, 3) uint8.
            depth: (B, size, size) float32 in units, 0 where there is nothing.

        Raises:
            ValueError: if the images are not `image_size` pixels wide and high.
        """
        self._check(rgb, depth)
        parts = []
        for first in range(0, len(rgb), BATCH):
            some = rgb[first : first + BATCH], depth[first : first + BATCH]
            cells = grid_of_blocks(self._look(*some), torch.from_numpy(np.ascontiguousarray(some[1])))
            for each, found in zip(cells, find_and_name_parts(self._naming, *some, self._reach), strict=True):
                add_things(each, found.things, self.image_size)
            parts.append(cells)
        return np.concatenate(parts)

    def blocks(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> Probabilities:
        """Return probabilities of kinds, colours and looks of each block; arguments as for `encode`."""
        self._check(rgb, depth)
        return self._look(rgb, depth)

    def things(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> list[list[DetectedThing]]:
        """Return the detected things on the ground in each frame, the nearest first; arguments as for `encode`."""
        return [found.things for found in self.parts(rgb, depth)]

    def parts(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> list[NamedParts]:
        """Return what is cut out of each frame; arguments as for `encode`."""
        self._check(rgb, depth)
        return find_and_name_parts(self._naming, rgb, depth, self._reach)

    def _look(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> Probabilities:
        with torch.inference_mode():
            return probabilities(self._blocks(prepare(rgb, depth)))

    def _check(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> None:
        wanted = (self.image_size, self.image_size)
        if rgb.shape[1:] != (*wanted, 3) or depth.shape != (len(rgb), *wanted):
            raise ValueError(
                f"images of shapes {rgb.shape} and {depth.shape}; expected (B, {wanted[0]}, {wanted[1]}, 3) and "
                f"(B, {wanted[0]}, {wanted[1]})"
            )


def write_weights(path: Path, blocks: EyesNetwork, naming: NamingNetwork) -> None:
    """Write both networks to a file, atomically."""
    header = {"format": FORMAT, "sizes": asdict(blocks.sizes)}
    write_weights_file(path, {"blocks.": blocks, "naming.": naming}, header)


def read_networks(path: Path) -> tuple[EyesNetwork, NamingNetwork]:
    """Return both networks of a file, in evaluation mode.

    Raises:
        BadWeights: if there is no such file, or it has other content.
    """
    file = read_weights_file(path, "the visual encoder", FORMAT, None)
    sizes = file.sizes("sizes", EyesSizes)
    blocks, naming = file.build(lambda: EyesNetwork(sizes)), NamingNetwork()
    networks: tuple[tuple[str, nn.Module], ...] = (("blocks.", blocks), ("naming.", naming))
    for prefix, network in networks:
        file.fill(network, prefix)
    return blocks, naming


def load_far() -> Eyes:
    """Return the encoder for agents that keep a map, which also sees things that are far and small."""
    return load(FAR_WEIGHTS, FAR)


def load(source: Path | None = None, reach: Reach = NEAR) -> Eyes:
    """Return the encoder, with the shipped weights or those of a file.

    Args:
        source: the file; None for the shipped one.
        reach: which things are cut out.

    Raises:
        BadWeights: if there is no such file, or it has other content.
    """
    path = source or WEIGHTS
    blocks, naming = networks = read_networks(path)
    for network in networks:
        network.requires_grad_(requires_grad=False)
        prepare_for_inference(network)
        network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    return Eyes(blocks, naming, f"eyes-{VERSION}-{hashlib.sha256(path.read_bytes()).hexdigest()[:12]}", reach)
