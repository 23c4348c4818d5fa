"""Faults that change one message, from which the breakers are built."""

from collections.abc import Callable, Iterable
from typing import Any

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from tests.conformance.forwarder import Fault, Stream, Unary


def answers(method: str, change: Callable[[Any], object]) -> Fault:
    """A fault that changes the answers of a unary method."""

    def unary(request: Any, call: Unary) -> Any:
        answer = call.forward(request)
        if call.method == method:
            change(answer)
        return answer

    return Fault(unary=unary)


def requests(method: str, **fields: Any) -> Fault:
    """A fault that puts other values into the requests of a unary method: what was wrong in them is not noticed."""

    def unary(request: Any, call: Unary) -> Any:
        if call.method == method:
            for name, value in fields.items():
                if value is None:
                    request.ClearField(name)
                elif isinstance(value, list):
                    request.ClearField(name)
                    getattr(request, name).extend(value)
                else:
                    setattr(request, name, value)
        return call.forward(request)

    return Fault(unary=unary)


def opens(**fields: Any) -> Fault:
    """A fault that puts other values into `open`."""

    def asks(request: pb.PlayRequest, _: Stream) -> Iterable[pb.PlayRequest]:
        if request.WhichOneof("message") == "open":
            for name, value in fields.items():
                setattr(request.open, name, value)
        return (request,)

    return Fault(asks=asks)


def acts(change: Callable[[list[pb.Act], Stream], object]) -> Fault:
    """A fault that changes the acts that reach the server."""

    def asks(request: pb.PlayRequest, stream: Stream) -> Iterable[pb.PlayRequest]:
        change(list(request.actions.acts), stream)
        return (request,)

    return Fault(asks=asks)


def events(kind: str, change: Callable[[Any], object], when: Callable[[Stream], bool] = lambda _: True) -> Fault:
    """A fault that changes the events of a kind that reach the client, on some streams."""

    def tells(event: pb.Event, stream: Stream) -> Iterable[pb.Event]:
        if event.WhichOneof("event") == kind and when(stream):
            change(getattr(event, kind))
        return (event,)

    return Fault(tells=tells)


def drops(kind: str) -> Fault:
    """A fault that swallows the events of a kind."""
    return Fault(tells=lambda event, _: () if event.WhichOneof("event") == kind else (event,))


def sets(**fields: Any) -> Callable[[Any], None]:
    """A change that sets fields."""

    def change(message: Any) -> None:
        for name, value in fields.items():
            setattr(message, name, value)

    return change


def clears(*names: str) -> Callable[[Any], None]:
    """A change that clears fields."""

    def change(message: Any) -> None:
        for name in names:
            message.ClearField(name)

    return change


def again(stream: Stream) -> bool:
    """Whether a stream is not the first."""
    return stream.number > 1


def mirrored(sent: list[pb.Act], _: Stream) -> None:
    other = {types_pb2.ACTION_LEFT: types_pb2.ACTION_RIGHT, types_pb2.ACTION_RIGHT: types_pb2.ACTION_LEFT}
    for act in sent:
        if act.HasField("action"):
            act.action = other.get(act.action, act.action)


def twice(kind: str) -> Callable[[pb.Event, Stream], Iterable[pb.Event]]:
    return lambda event, _: (event, event) if event.WhichOneof("event") == kind else (event,)
