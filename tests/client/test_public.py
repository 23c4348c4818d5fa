"""The client's public names."""

import arramon_client
from arramon_client import agent


def test_public_names_are_stable() -> None:
    assert sorted(arramon_client.__all__) == [
        "Access",
        "Action", "Agent", "AgentError", "AgentFailure", "AgentLoadError", "AgentStoppedError", "Answer",
        "ArramonClientError", "AsyncAgent", "AsyncRun", "AsyncRunEpisode", "EmbeddedServer",
        "EmbeddedServerError", "EncryptionError", "Episode", "EpisodeLostError", "MessageTooLargeError",
        "NotArramonError", "Observation",
        "Outcome", "OutputError", "Progress", "ProtocolError", "RefusedError", "Run", "RunClosedError", "RunEpisode",
        "RunInfo", "Server", "ServerUnreachableError",
        "Settings", "StepAheadError", "StepSpentError", "StopRun", "UsageError", "VersionMismatchError", "connect",
        "embedded_server", "load_agent", "play", "play_async",
    ]  # fmt: skip
    assert all(hasattr(arramon_client, name) for name in arramon_client.__all__)


def test_agent_contract_fields_are_stable() -> None:
    assert [(action.name, action.value) for action in agent.Action] == [
        ("FORWARD", 0), ("LEFT", 1), ("RIGHT", 2), ("INTERACT", 3),
    ]  # fmt: skip
    assert list(agent.Observation.__dataclass_fields__) == [
        "episode_id", "turn", "phase", "step", "instruction", "phase_step", "steps_left", "rgb", "depth", "pose",
        "segmentation",
        "step_seconds_left",
        "bank_seconds_left", "taken", "taken_note", "arrived",
    ]  # fmt: skip
    assert list(agent.Episode.__dataclass_fields__) == ["episode_id", "language", "split", "oracle", "labels"]
