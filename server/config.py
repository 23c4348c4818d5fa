"""What a host can set."""

from dataclasses import dataclass
from pathlib import Path

from server.addresses import FORM, TCP_FORM, is_address, is_loopback, is_tcp_address
from server.errors import BadInput
from server.runs.clocks import Clocks
from server.setting import setting, settings_of
from server.sim.cameras import CAMERAS
from server.sim.rules import STEPS_PER_PHASE, Limits

LISTEN = "127.0.0.1:50551"
"""Loopback: what others may reach, a host says."""

DAY = 86_400.0


class Contradiction(BadInput):
    """Settings that do not go together.

    Args:
        names: of the settings.
    """

    def __init__(self, problem: str, *names: str) -> None:
        super().__init__(problem)
        self.names = names


@dataclass(frozen=True, slots=True)
class Config:
    """The server's settings. Each is described where it stands; `docs/configuration.md` has them all.

    Raises:
        Contradiction: for settings that do not go together.
    """

    data: Path = setting(
        Path("arramon-data"), "folder with the episodes and, unless `journal` says otherwise, the journal"
    )
    listen: str = setting(LISTEN, "address to serve on; port 0 takes a free one", form=FORM, check=is_address)
    journal: str = setting(
        "",
        "database URL; empty for SQLite in the data folder",
        form="sqlite:///PATH or postgresql://USER:...@HOST/NAME",
        check=lambda text: text.partition("://")[0].partition("+")[0] in ("sqlite", "postgresql", "postgres"),
        secret=True,
    )
    fsync: bool = setting(True, "whether a step outlives a loss of power too, not only the end of a process (SQLite)")
    workers: int = setting(1, "processes that serve", least=1, most=256)
    camera: str = setting(CAMERAS[0], "what draws: the fast camera, or pybullet's", choices=CAMERAS)
    image_sizes: tuple[int, ...] = setting(
        (224, 128),
        "side lengths that a stream may ask for; the first is the default",
        unit="pixels",
        least=16,
        most=1024,
    )
    steps: int = setting(STEPS_PER_PHASE, "limit of a phase", unit="steps", least=1, most=10_000)
    step_seconds: float = setting(60.0, "time of each step; 0 for no clocks", unit="seconds", least=0.0, most=DAY)
    first_step_seconds: float = setting(
        600.0, "time of a run's first step, while models load", unit="seconds", least=0.0, most=DAY
    )
    bank_seconds: float = setting(
        3600.0, "time that all steps of a run may take beyond `step_seconds`", unit="seconds", least=0.0, most=365 * DAY
    )
    idle_seconds: float = setting(
        7 * DAY,
        "how long a run may lie idle before it is closed with what it has; 0 for ever",
        unit="seconds",
        least=0.0,
    )
    keepalive_seconds: float = setting(
        20.0,
        "silence after which a client is asked for a sign of life; without one it is gone half as long later",
        unit="seconds",
        least=1.0,
        most=3600.0,
    )
    max_episodes_per_stream: int = setting(1024, "that a stream may have open at once", unit="episodes", least=1)
    max_calls: int = setting(
        4096, "calls and streams that a process has open at once; more are refused", unit="calls", least=16
    )
    max_message_bytes: int = setting(1 << 20, "the largest message accepted", unit="bytes", least=4096, most=64 << 20)
    anonymous: bool | None = setting(
        None,
        "whether those without a token may play; not set: where `listen` is a Unix socket or of the loopback, "
        "and `trust_proxy` is off",
    )
    runs_per_day: int = setting(
        0, "that a participant may create on a split in 24 hours; 0 for any", unit="runs", least=0
    )
    runs_in_all: int = setting(0, "that a participant may create on a split; 0 for any", unit="runs", least=0)
    runs_at_once: int = setting(0, "that a participant may have unfinished on a split; 0 for any", unit="runs", least=0)
    streams_at_once: int = setting(0, "that a participant may have open on a split; 0 for any", unit="streams", least=0)
    tls_certificate: Path | None = setting(None, "PEM file with the certificate chain; not set: no encryption")
    tls_key: Path | None = setting(None, "PEM file with the certificate's private key")
    trust_proxy: bool = setting(
        False, "whether tokens are taken from unencrypted connections, as a proxy in front encrypts them"
    )
    signing_key: Path | None = setting(
        None, "PEM file with the Ed25519 key that signs receipts; not set: one in the data folder, made on first use"
    )
    web: str = setting("", "address of the pages and probes; empty for none", form=TCP_FORM, check=is_tcp_address)
    metrics: str = setting(
        "",
        "address of the metrics, which may be that of `web`; empty: with `web` if that is of the loopback, or none",
        form=TCP_FORM,
        check=is_tcp_address,
    )
    drain_seconds: float = setting(
        10.0,
        "how long open calls may take to end when the server is told to stop",
        unit="seconds",
        least=0.0,
        most=3600.0,
    )
    log: str = setting("warning", "how much to log", choices=("debug", "info", "warning", "error"))
    log_format: str = setting("text", "a line of text or a JSON object for each event", choices=("text", "json"))
    shared_port: bool = setting(False, "whether other processes may listen on the same ports", internal=True)
    own_address: str = setting(
        "", "a second address, of this process alone", form=FORM, check=is_address, internal=True
    )

    def __post_init__(self) -> None:
        for present, absent in (("tls_certificate", "tls_key"), ("tls_key", "tls_certificate")):
            if getattr(self, present) is not None and getattr(self, absent) is None:
                raise Contradiction(f"{present} is set and {absent} is not, expected both or neither", present, absent)
        for name in ("web", "metrics"):
            address = getattr(self, name)
            if address and address == self.listen and not address.endswith(":0"):
                raise Contradiction(f"{name} and listen are both {address}, expected two addresses", name, "listen")

    @property
    def limits(self) -> Limits:
        """Given to runs that are created."""
        return Limits(self.steps)

    @property
    def clocks(self) -> Clocks:
        """Given to runs that are created."""
        if not self.step_seconds:
            return Clocks()
        return Clocks(self.step_seconds, max(self.first_step_seconds, self.step_seconds), self.bank_seconds)

    @property
    def journal_url(self) -> str:
        """The database's URL."""
        return self.journal or f"sqlite:///{self.data.absolute() / 'journal.db'}"

    @property
    def signing_key_path(self) -> Path:
        """The file of the key that signs receipts."""
        return self.signing_key or self.data / "signing-key.pem"

    @property
    def metrics_address(self) -> str:
        """Where the metrics are; empty where they are not."""
        return self.metrics or (self.web if self.web and is_loopback(self.web) else "")

    @property
    def http(self) -> dict[str, str]:
        """What is served where over HTTP, if anything: "pages" and "metrics", by URL."""
        scheme = "https" if self.tls_certificate else "http"
        places = {"pages": self.web, "metrics": self.metrics_address}
        return {name: f"{scheme}://{address}" for name, address in places.items() if address}


SETTINGS = settings_of(Config)
"""The settings by name, in order."""
