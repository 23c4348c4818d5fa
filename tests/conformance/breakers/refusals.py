"""Faults in refusals: of another status, without a message, or none where one is due."""

import grpc

from tests.conformance.breakers.faults import opens, requests
from tests.conformance.forwarder import Fault

WRONG_STATUS = Fault(refuses=lambda _, details: (grpc.StatusCode.UNKNOWN, details))
NO_MESSAGE = Fault(refuses=lambda code, _: (code, ""))

REFUSALS = (
    "notes.private", "notes.refused",
    "version.refused", "limits.max_episodes", "limits.message", "refusals.split", "refusals.language",
    "refusals.sensors", "refusals.hidden_sensors", "refusals.hidden_part", "refusals.agent",
    "refusals.chosen", "refusals.arguments", "refusals.code", "refusals.episodes",
    "refusals.unknown_run", "refusals.page", "refusals.first_message", "refusals.image_size", "refusals.encoding",
    "refusals.quality", "refusals.unfinished", "refusals.token", "refusals.anonymous", "results.cancelled",
)  # fmt: skip
"""Checks that expect refusals: each notices a wrong status, and a message that is empty."""

ACCEPTED = [
    ("refusals.split", requests("CreateRun", split="tiny"), "a run on an unknown split was accepted"),
    ("refusals.language", requests("CreateRun", language="en"), "a run in an unknown language was accepted"),
    ("refusals.sensors", requests("CreateRun", sensors=[]), "a run with an unknown sensor was accepted"),
    ("refusals.hidden_sensors", requests("CreateRun", sensors=["rgb"]), "with the sensor 'segmentation' was accepted"),
    ("refusals.hidden_part", requests("CreateRun", episodes=0), "one episode of a hidden split was accepted"),
    ("refusals.agent", requests("CreateRun", agent="somebody"), "an agent without a name was accepted"),
    ("refusals.episodes", requests("CreateRun", episodes=1), "a run of 7 episodes of 6 was accepted"),
    ("refusals.hidden_part", requests("CreateRun", episode_ids=[], episodes=0), "one episode of a hidden split was"),
    ("refusals.chosen", requests("CreateRun", episode_ids=[]), "a run of an unknown episode was accepted"),
    ("refusals.arguments", requests("CreateRun", agent_arguments=[]), "whose name is no identifier was accepted"),
    ("refusals.code", requests("CreateRun", code=None), "with an address of another kind was accepted"),
    ("refusals.page", requests("ListRuns", page_size=1000), "a page of 1001 runs was accepted"),
    ("refusals.image_size", opens(image_size=0), "a stream with images of 225 pixels was accepted"),
    ("refusals.encoding", opens(encoding=0), "a stream with the encoding 5 was accepted"),
    ("refusals.quality", opens(jpeg_quality=0), "with ENCODING_JPEG and jpeg_quality 101 was accepted"),
]
