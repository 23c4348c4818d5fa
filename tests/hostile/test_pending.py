"""Calls that reach a busy server together: none is dropped before the server has seen it."""

import os
import signal
import time
from collections import Counter
from contextlib import ExitStack

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from tests.serving import METADATA, Server

CHANNELS, CALLS = 10, 180
"""Channels, and calls of each: more in all than the 1,000 from which on gRPC drops some, fewer than `max_calls`."""


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="pauses the server by SIGSTOP")
def test_calls_that_arrive_while_the_server_is_paused_are_all_answered(server: Server) -> None:
    with ExitStack() as stack:
        pool = [("grpc.use_local_subchannel_pool", 1)]
        stubs = [
            EvaluationStub(stack.enter_context(grpc.insecure_channel(server.address, options=pool)))
            for _ in range(CHANNELS)
        ]
        for stub in stubs:  # connects
            stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA)
        os.kill(server.process.pid, signal.SIGSTOP)
        try:
            calls = [
                stub.GetServerInfo.future(pb.GetServerInfoRequest(), metadata=METADATA)
                for stub in stubs
                for _ in range(CALLS)
            ]
            time.sleep(1.0)  # so that they wait in the server's sockets; if some do not yet, the test is only easier
        finally:
            os.kill(server.process.pid, signal.SIGCONT)
        assert Counter(call.code() for call in calls) == {grpc.StatusCode.OK: CHANNELS * CALLS}
