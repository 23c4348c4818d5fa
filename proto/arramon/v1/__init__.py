"""Version 1 of the protocol. The stubs are made by `scripts/protos` and never edited by hand."""

PROTOCOL = 1
"""The protocol's number. Server and client exchange it before anything else."""

PROTOCOL_METADATA = "arramon-protocol"
"""The key of the gRPC metadata in which a client names its protocol."""
