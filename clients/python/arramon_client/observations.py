"""Conversion of protocol messages to the agent contract's episodes and observations."""

import time

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client.agent import Episode, Label, Observation
from arramon_client.transport.images import ImageDecoder

PHASES = {types_pb2.PHASE_NAVIGATION: "navigation", types_pb2.PHASE_ASSEMBLY: "assembly"}


def labels_of(opened: evaluation_pb2.Opened) -> tuple[Label, ...]:
    """Return the labels of a stream's segmentations, by value; empty without segmentations."""
    return tuple(Label(label.kind, label.colour, label.look) for label in opened.labels)


def episode_of(started: evaluation_pb2.EpisodeStarted, labels: tuple[Label, ...] = ()) -> Episode:
    """Return the episode that a message announces, with the labels of its stream."""
    return Episode(
        episode_id=started.episode_id,
        language=started.language,
        split=started.split,
        oracle=started.oracle if started.HasField("oracle") else None,
        labels=labels,
    )


def observation_of(
    message: evaluation_pb2.Observation, decoder: ImageDecoder, arrived: float | None = None
) -> Observation:
    """Return a message's observation with its images decoded.

    Args:
        message: the message.
        decoder: decoder of its stream's images.
        arrived: `time.monotonic()` when it was received; None for now.

    Raises:
        ProtocolError: if an image cannot be decoded.
    """
    pose = message.pose
    return Observation(
        episode_id=message.episode_id,
        turn=message.turn,
        phase=PHASES.get(message.phase, ""),
        step=message.step,
        instruction=message.instruction,
        phase_step=message.phase_step,
        steps_left=message.steps_left,
        rgb=decoder.rgb(message.rgb) if message.HasField("rgb") else None,
        depth=decoder.depth(message.depth) if message.HasField("depth") else None,
        pose=(pose.x, pose.z, pose.heading) if message.HasField("pose") else None,
        segmentation=decoder.segmentation(message.segmentation) if message.HasField("segmentation") else None,
        step_seconds_left=message.step_seconds_left if message.HasField("step_seconds_left") else None,
        bank_seconds_left=message.bank_seconds_left if message.HasField("bank_seconds_left") else None,
        taken=message.taken if message.HasField("taken") else None,
        taken_note=message.taken_note if message.HasField("taken_note") else None,
        arrived=time.monotonic() if arrived is None else arrived,
    )


def nondeterminism_warning(replayed: Observation, action: int) -> str:
    """Return the warning that an agent chose another action for a replayed observation than the recorded one."""
    return (
        f"the agent is not deterministic: at step {replayed.step} of episode {replayed.episode_id} it took "
        f"{replayed.taken} before, but now {action}; its state may differ from the original one"
    )
