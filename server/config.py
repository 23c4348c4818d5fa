"""What a host can set."""

from dataclasses import dataclass, field
from pathlib import Path

from server.errors import BadInput
from server.sim.cameras import CAMERAS
from server.sim.rules import Limits

MAX_WORKERS = 256
"""Processes of one server on one machine."""

LISTEN = "127.0.0.1:50551"
"""Loopback: what others may reach, a host says."""


@dataclass(frozen=True, slots=True)
class Config:
    """The server's settings.

    Attributes:
        data: folder with the episodes and, unless `journal` says otherwise, the journal.
        listen: address, `host:port` or `unix:/path`; port 0 takes a free one.
        shared_port: whether other processes may listen on the same port.
        own_address: a second address, of this process alone; empty for none.
        journal: database URL; empty for SQLite in the data folder.
        fsync: whether a step outlives a loss of power too, not only the end of a process (SQLite).
        camera: what draws the frames, one of `server.sim.cameras.CAMERAS`.
        limits: given to runs that are created.
        image_sizes: side lengths in pixels that a stream may ask for; the first is the default.
        max_episodes_per_stream: that a stream may have open at once.
        max_message_bytes: the largest message accepted.
        tls_certificate, tls_key: PEM files; None for no encryption.
        trust_proxy: whether tokens are taken from unencrypted connections, as a proxy in front encrypts them.
        anonymous: whether those without a token may play; None for on this machine's loopback and Unix sockets only.
        runs_per_day, runs_in_all, runs_at_once, streams_at_once: of one participant on one split; 0 for no limit.
        idle_seconds: for which a run may lie idle before it is closed with what it has; 0 for ever.
        web: address of the pages, probes and metrics, `host:port`; empty for none.
        log_format: "text" or "json".

    Raises:
        BadInput: for a setting out of range.
    """

    data: Path
    listen: str = LISTEN
    shared_port: bool = False
    own_address: str = ""
    journal: str = ""
    fsync: bool = True
    camera: str = CAMERAS[0]
    limits: Limits = field(default_factory=Limits)
    image_sizes: tuple[int, ...] = (224, 128)
    max_episodes_per_stream: int = 1024
    max_message_bytes: int = 1 << 20
    tls_certificate: Path | None = None
    tls_key: Path | None = None
    trust_proxy: bool = False
    anonymous: bool | None = None
    runs_per_day: int = 0
    runs_in_all: int = 0
    runs_at_once: int = 0
    streams_at_once: int = 0
    idle_seconds: float = 7 * 86_400.0
    web: str = ""
    log_format: str = "text"

    def __post_init__(self) -> None:
        if not 1 <= self.limits.steps_per_phase <= 10_000:
            raise BadInput(f"the step limit is {self.limits.steps_per_phase}, expected 1 to 10000")
        if self.camera not in CAMERAS:
            raise BadInput(f"there is no camera {self.camera!r}; there are {', '.join(CAMERAS)}")
        host, _, port = self.listen.rpartition(":")
        if not (self.listen.startswith("unix:") or (host and port.isdecimal() and int(port) <= 65535)):
            raise BadInput(f"cannot listen on {self.listen!r}: expected host:port or unix:/path")

    @property
    def journal_url(self) -> str:
        """The database's URL."""
        return self.journal or f"sqlite:///{self.data.absolute() / 'journal.db'}"
