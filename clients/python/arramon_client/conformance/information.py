"""Checks of the information about the server, its splits and the caller, and of protocol versions."""

import grpc

from arramon.v1 import PROTOCOL, PROTOCOL_METADATA, types_pb2
from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_client.conformance.assertions import expect, expect_equal, expect_refusal, need
from arramon_client.conformance.suite import check
from arramon_client.conformance.target import Target
from arramon_client.transport.access import Access, host_of
from arramon_client.transport.channel import open_channel
from arramon_client.transport.connection import CHANNEL_OPTIONS, METADATA
from arramon_client.world import SENSORS

PRIVILEGED = ("segmentation", "pose", "oracle")
"""Sensors that reveal targets, goals or the agent's position."""


@check("information.server")
def server(target: Target) -> None:
    """GetServerInfo returns the release, the protocol, all limits and the host's 32-byte public key."""
    info = target.call("GetServerInfo", pb.GetServerInfoRequest())
    expect(info.version, "the version is empty, expected the server's release")
    expect_equal("the protocol", info.protocol, PROTOCOL)
    for name in ("max_episodes_per_stream", "max_message_bytes"):
        expect(getattr(info, name) > 0, f"{name} is 0, expected 1 or more")
    expect(info.limits.steps_per_phase > 0, "limits.steps_per_phase is 0, expected 1 or more")
    expect_equal("the length of the public key in bytes", len(info.public_key), 32)


@check("information.splits")
def splits(target: Target) -> None:
    """Each split has a unique name, episodes in at least one language, known sensors and a SHA-256 of its data."""
    offered = target.info.splits
    names = [split.name for split in offered]
    expect(len(set(names)) == len(names), f"two splits have the same name among {names}")
    for split in offered:
        named = f"split {split.name!r}"
        expect(any(split.episodes.values()), f"{named} has no episodes in any language, expected some")
        unknown = set(split.sensors) - set(SENSORS)
        expect(not unknown, f"{named} offers the sensors {sorted(unknown)}, expected some of {', '.join(SENSORS)}")
        is_hash = len(split.data_hash) == 64 and set(split.data_hash) <= set("0123456789abcdef")
        expect(is_hash, f"{named} has the data hash {split.data_hash!r}, expected 64 hexadecimal digits")


@check("information.hidden")
def hidden(target: Target) -> None:
    """A hidden split offers no sensor that reveals targets, goals, paths or the agent's position."""
    found = [split for split in target.info.splits if split.hidden]
    need(found, "the server has no hidden split; one would make it run")
    for split in found:
        revealing = sorted(set(split.sensors) & set(PRIVILEGED))
        expect(not revealing, f"the hidden split {split.name!r} offers {', '.join(revealing)}, expected none of these")


@check("information.encodings")
def encodings(target: Target) -> None:
    """Each encoding is listed once, shared memory last, and image sizes are whole numbers above 0."""
    offered = list(target.info.encodings)
    expect(offered, "no encoding is offered, expected one or more")
    known = set(types_pb2.Encoding.values()) - {types_pb2.ENCODING_UNSPECIFIED}
    expect(set(offered) <= known, f"the encodings are {offered}, expected numbers of {sorted(known)}")
    expect(len(set(offered)) == len(offered), f"the encodings are {offered}, expected each once")
    shared = types_pb2.ENCODING_SHARED
    expect(shared not in offered[:-1], "ENCODING_SHARED is not the last of the encodings, expected it last")
    sizes = list(target.info.image_sizes)
    expect(sizes and min(sizes) > 0, f"the image sizes are {sizes}, expected one or more above 0")


@check("information.open")
def open_to_all(target: Target) -> None:
    """GetServerInfo also answers callers without a token."""
    access = target.server.access
    need(access.token, "the suite was given no token; --token-file would make it run")
    name = access.name or host_of(target.server.address)
    address = target.server.address
    bare = Access(tls=access.encrypts(address), authority=access.authority, name=access.name)
    with open_channel(address, bare, CHANNEL_OPTIONS) as channel:
        info = EvaluationStub(channel).GetServerInfo(
            pb.GetServerInfoRequest(), timeout=target.timeout, metadata=METADATA
        )
    expect_equal(f"the protocol of {name}, asked without a token,", info.protocol, PROTOCOL)


@check("version.refused")
def version(target: Target) -> None:
    """A client with another protocol version, or without one, is refused: FAILED_PRECONDITION."""
    code = grpc.StatusCode.FAILED_PRECONDITION
    other = PROTOCOL + 1
    for metadata, said in ((((PROTOCOL_METADATA, str(other)),), f"protocol {other}"), ((), "no protocol")):

        def ask(metadata: tuple[tuple[str, str], ...] = metadata) -> None:
            target.call("GetServerInfo", pb.GetServerInfoRequest(), metadata)

        def play(metadata: tuple[tuple[str, str], ...] = metadata) -> None:
            with target.play_raw(pb.PlayRequest(open=pb.Open(run_id="none")), metadata) as stream:
                list(stream.rest())

        expect_refusal(f"GetServerInfo with {said}", ask, code)
        expect_refusal(f"Play with {said}", play, code)


@check("account.quotas")
def account(target: Target) -> None:
    """GetAccount returns the caller's role, and one quota for each split."""
    found = target.call("GetAccount", pb.GetAccountRequest())
    expect(found.role != pb.ROLE_UNSPECIFIED, "the role is unspecified, expected anonymous, participant or host")
    token = target.server.access.token
    expect(
        (found.role == pb.ROLE_ANONYMOUS) == (not token),
        f"the role is {pb.Role.Name(found.role)} for a caller with{'' if token else 'out'} a token",
    )
    named = sorted(quota.split for quota in found.quotas)
    expect_equal("the list of splits with a quota", named, sorted(split.name for split in target.info.splits))


CHECKS = (server, splits, hidden, encodings, open_to_all, version, account)
