"""A gRPC server that forwards every call to a real one, and breaks one promise of the contract at a time."""

# ruff: noqa: N802 - gRPC names the methods

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import partialmethod
from typing import Any

import grpc

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationServicer, EvaluationStub, add_EvaluationServicer_to_server

Metadata = tuple[tuple[str, str], ...]

PASSED_ON = ("arramon-protocol", "authorization")
"""Metadata that is forwarded."""


class Refusal(Exception):
    """Ends a call with a status of the forwarder's own."""

    def __init__(self, code: grpc.StatusCode, details: str) -> None:
        super().__init__(details)
        self.code, self.details = code, details


@dataclass
class Unary:
    """A unary call: its method, its metadata, and the way to the real server."""

    method: str
    metadata: Metadata
    forward: Callable[[Any], Any]


@dataclass
class Stream:
    """A Play stream.

    Attributes:
        number: 1 for the first stream since the fault was installed.
        opening: what the client asked for.
        own: for the fault to remember things about this stream.
        common: the same, for all streams.
    """

    number: int
    common: dict[Any, Any]
    opening: pb.Open = field(default_factory=pb.Open)
    own: dict[Any, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Fault:
    """What is broken; by default nothing.

    Attributes:
        unary: answers a unary call.
        asks: what reaches the server of a message that a client sent on a stream.
        tells: what reaches the client of an event.
        ends: events that reach the client in place of the error with which a stream ends; None for the error.
        refuses: code and message of a refusal, as they reach the client.
        metadata: what reaches the server of a call's metadata.
    """

    unary: Callable[[Any, Unary], Any] = lambda request, call: call.forward(request)
    asks: Callable[[pb.PlayRequest, Stream], Iterable[pb.PlayRequest]] = lambda request, _: (request,)
    tells: Callable[[pb.Event, Stream], Iterable[pb.Event]] = lambda event, _: (event,)
    ends: Callable[[Stream], Iterable[pb.Event]] | None = None
    refuses: Callable[[grpc.StatusCode, str], tuple[grpc.StatusCode, str]] = lambda code, details: (code, details)
    metadata: Callable[[Metadata], Metadata] = lambda metadata: metadata


class Forwarder(EvaluationServicer):
    """Forwards calls.

    Attributes:
        address: where it is reached.
    """

    def __init__(self, stub: EvaluationStub, address: str) -> None:
        self.address = address
        self._stub = stub
        self._fault = Fault()
        self._common: dict[Any, Any] = {}
        self._streams = 0

    def install(self, fault: Fault) -> None:
        """Break this from now on, and nothing else."""
        self._fault, self._common, self._streams = fault, {}, 0

    def Play(self, request_iterator: Iterator[pb.PlayRequest], context: Any) -> Iterator[pb.PlayResponse]:
        fault = self._fault
        self._streams += 1
        stream = Stream(self._streams, self._common)

        def asked() -> Iterator[pb.PlayRequest]:
            with suppress(grpc.RpcError):  # The client has gone.
                for request in request_iterator:
                    if request.WhichOneof("message") == "open":
                        stream.opening.CopyFrom(request.open)
                    yield from fault.asks(request, stream)

        call = self._stub.Play(asked(), metadata=fault.metadata(_metadata(context)))
        context.add_callback(call.cancel)
        try:
            for response in call:
                events = [told for event in response.events for told in fault.tells(event, stream)]
                yield pb.PlayResponse(events=events)
        except Refusal as refusal:
            call.cancel()
            context.abort(refusal.code, refusal.details)
        except grpc.RpcError as error:
            if fault.ends is None:
                context.abort(*fault.refuses(error.code(), error.details() or ""))
            else:
                yield pb.PlayResponse(events=fault.ends(stream))

    def unary(self, method: str, request: Any, context: Any) -> Any:
        fault, metadata = self._fault, _metadata(context)
        sent = fault.metadata(metadata)
        call = Unary(method, metadata, lambda message: getattr(self._stub, method)(message, metadata=sent))
        try:
            return fault.unary(request, call)
        except Refusal as refusal:
            context.abort(refusal.code, refusal.details)
        except grpc.RpcError as error:
            context.abort(*fault.refuses(error.code(), error.details() or ""))


for name in pb.DESCRIPTOR.services_by_name["Evaluation"].methods_by_name:
    if name != "Play":
        setattr(Forwarder, name, partialmethod(Forwarder.unary, name))


@contextmanager
def forwarding(target: str, address: str) -> Iterator[Forwarder]:
    """Serve a forwarder at an address, to the real server at another."""
    server = grpc.server(ThreadPoolExecutor(16))
    with grpc.insecure_channel(target) as channel:
        forwarder = Forwarder(EvaluationStub(channel), address)  # type: ignore[abstract]  # its unary methods are set above
        add_EvaluationServicer_to_server(forwarder, server)
        server.add_insecure_port(address)
        server.start()
        try:
            yield forwarder
        finally:
            server.stop(0).wait()


def _metadata(context: Any) -> Metadata:
    return tuple((key, value) for key, value in context.invocation_metadata() if key in PASSED_ON)
