"""Tests of the Play stream."""

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client.transport.stream import ACTS_IN_MESSAGE, PlayStream
from arramon_client.world import NOTE_BYTES

DEFAULT_LIMIT = 1 << 20


class SilentStub:
    """Stub whose stream keeps the requests and answers nothing."""

    def __init__(self) -> None:
        self.requests: list[evaluation_pb2.PlayRequest] = []

    def Play(self, requests: object, metadata: object) -> "SilentStub":  # noqa: N802 - gRPC's name
        self.pending = iter(requests)  # type: ignore[call-overload]
        return self

    def cancel(self) -> None:
        """Take all requests, as the stream ends."""
        self.requests = list(self.pending)


def test_a_batch_with_the_longest_notes_is_sent_in_messages_that_a_server_accepts() -> None:
    stub = SilentStub()
    stream = PlayStream(stub, evaluation_pb2.Open(max_episodes=1))  # type: ignore[arg-type]
    acts = [
        evaluation_pb2.Act(
            episode_id=f"{number:036}", step=number, action=types_pb2.ACTION_FORWARD, note="n" * NOTE_BYTES
        )
        for number in range(ACTS_IN_MESSAGE * 2 + 1)
    ]
    stream.send(acts)
    stream._outgoing.put(None)
    stream.close()
    _, *messages = stub.requests
    assert [len(message.actions.acts) for message in messages] == [ACTS_IN_MESSAGE, ACTS_IN_MESSAGE, 1]
    assert [act for message in messages for act in message.actions.acts] == acts
    assert max(message.ByteSize() for message in messages) < DEFAULT_LIMIT


def test_acts_that_wait_at_the_same_time_share_a_message() -> None:
    stub = SilentStub()
    stream = PlayStream(stub, evaluation_pb2.Open(max_episodes=1))  # type: ignore[arg-type]
    acts = [evaluation_pb2.Act(episode_id="e0", step=step) for step in range(ACTS_IN_MESSAGE + 2)]
    for act in acts:
        stream.send([act])
    stream._outgoing.put(None)
    stream.close()
    opening, *messages = stub.requests
    assert opening.HasField("open")
    assert [len(message.actions.acts) for message in messages] == [ACTS_IN_MESSAGE, 2]
    assert [act for message in messages for act in message.actions.acts] == acts
