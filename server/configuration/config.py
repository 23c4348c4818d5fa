"""The server's settings, with their defaults and descriptions."""

from dataclasses import dataclass
from pathlib import Path

from arramon_client.world import NOTE_BYTES, STEPS_PER_PHASE
from arramon_server.addresses import FORM, TCP_FORM, is_address, is_loopback, is_tcp_address
from arramon_server.configuration.setting import setting, settings_of
from arramon_server.errors import BadInput
from arramon_server.per_split import MAX_LIMIT, PerSplit
from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.play.note_limits import RUN_NOTE_BYTES, NoteLimits
from arramon_server.sim.cameras import CAMERAS
from arramon_server.sim.physics import problem_of_camera
from arramon_server.sim.rules import Limits
from arramon_server.split_times import NO_TIMES, SplitTimes
from arramon_server.visible_text import is_visible

MAX_LINE_LENGTH = 500

LINE = f"one line of at most {MAX_LINE_LENGTH} characters"

LISTEN = "127.0.0.1:50551"
"""Default address. It is a loopback address: other machines can connect only if the host sets another one."""

DAY = 86_400.0


def is_line(text: str) -> bool:
    """Return whether a text is one line of visible text."""
    return len(text) <= MAX_LINE_LENGTH and is_visible(text)


class ContradictorySettings(BadInput):
    """Settings that contradict each other.

    Args:
        problem: the error message.
        names: the settings involved.
    """

    def __init__(self, problem: str, *names: str) -> None:
        super().__init__(problem)
        self.names = names


@dataclass(frozen=True, slots=True)
class Config:
    """The server's settings, each with its description; `docs/reference/configuration.md` lists them.

    Raises:
        ContradictorySettings: if settings contradict each other.
    """

    data: Path = setting(Path("arramon-data"), "folder with the episodes and, unless `journal` is set, the journal")
    listen: str = setting(
        LISTEN, "address to serve on; port 0 chooses a free port", form=FORM, check=is_address, of_public_server=True
    )
    journal: str = setting(
        "",
        "database URL; empty for SQLite in the data folder",
        form="sqlite:///PATH or postgresql://USER:...@HOST/NAME",
        check=lambda text: text.partition("://")[0].partition("+")[0] in ("sqlite", "postgresql", "postgres"),
        secret=True,
    )
    fsync: bool = setting(
        True, "whether recorded steps survive a power failure, not only the end of the process (SQLite only)"
    )
    workers: int = setting(1, "number of server processes", least=1, most=256)
    camera: str = setting(
        CAMERAS[0],
        "renderer of the images: the project's own fast camera, or pybullet's, which must be installed",
        choices=CAMERAS,
    )
    image_sizes: tuple[int, ...] = setting(
        (224, 128),
        "image side lengths that a stream may request; the first is the default",
        unit="pixels",
        least=16,
        most=1024,
    )
    steps: int = setting(STEPS_PER_PHASE, "step limit of a phase", unit="steps", least=1, most=10_000)
    step_seconds: float = setting(
        60.0, "time limit of each step; 0 disables all clocks", unit="seconds", least=0.0, most=DAY
    )
    bank_seconds: float = setting(
        DAY,
        "reserve of a run for answers that take longer than `step_seconds`, with or without a connection",
        unit="seconds",
        least=0.0,
        most=365 * DAY,
    )
    keepalive_seconds: float = setting(
        20.0,
        "silence after which the server pings a client; without an answer in half that time the client counts as gone",
        unit="seconds",
        least=1.0,
        most=3600.0,
    )
    max_episodes_per_stream: int = setting(
        1024, "limit of a stream's concurrently open episodes", unit="episodes", least=1
    )
    max_calls: int = setting(
        4096, "limit of a process's concurrently open calls and streams; more are refused", unit="calls", least=16
    )
    max_message_bytes: int = setting(
        1 << 20, "size limit of a message that the server accepts", unit="bytes", least=4096, most=64 << 20
    )
    note_bytes: int = setting(
        NOTE_BYTES,
        "size limit of a note that an agent leaves beside a step; 0: no notes are stored",
        unit="bytes",
        least=0,
        most=NOTE_BYTES,
    )
    run_note_bytes: int = setting(
        RUN_NOTE_BYTES, "size limit of all notes of a run", unit="bytes", least=0, most=1_000_000_000
    )
    anonymous: bool | None = setting(
        None,
        "whether clients without a token may play; not set: only if `listen` is a Unix socket or a loopback address, "
        "and `trust_proxy` is off",
        of_public_server=True,
    )
    runs_per_day: PerSplit = setting(
        PerSplit(),
        "limit of runs that a participant may create on a split in 24 hours; 0 for no limit; not set: "
        "3 on hidden splits, 200 on others, none for callers without a token on their own machine",
        unit="runs",
        least=0,
        most=MAX_LIMIT,
        of_public_server=True,
    )
    runs_in_all: PerSplit = setting(
        PerSplit(),
        "limit of runs that a participant may create on a split in total; 0, and not set: no limit",
        unit="runs",
        least=0,
        most=MAX_LIMIT,
        of_public_server=True,
    )
    runs_at_once: PerSplit = setting(
        PerSplit(),
        "limit of a participant's unfinished runs on a split; 0 for no limit; not set: "
        "3 on hidden splits, 20 on others, none for callers without a token on their own machine",
        unit="runs",
        least=0,
        most=MAX_LIMIT,
        of_public_server=True,
    )
    streams_at_once: PerSplit = setting(
        PerSplit(),
        "limit of a participant's open streams on a split; 0 for no limit; not set: "
        "64, none for callers without a token on their own machine",
        unit="streams",
        least=0,
        most=MAX_LIMIT,
        of_public_server=True,
    )
    tls_certificate: Path | None = setting(
        None, "PEM file with the certificate chain; not set: no encryption", of_public_server=True
    )
    tls_key: Path | None = setting(None, "PEM file with the certificate's private key", of_public_server=True)
    trust_proxy: bool = setting(
        False,
        "whether tokens are accepted over unencrypted connections, because a proxy in front encrypts them",
        of_public_server=True,
    )
    signing_key: Path | None = setting(
        None, "PEM file with the Ed25519 key that signs receipts; not set: one in the data folder, made on first use"
    )
    web: str = setting(
        "",
        "address of the pages and probes; empty for none",
        form=TCP_FORM,
        check=is_tcp_address,
        of_public_server=True,
    )
    play_page: bool = setting(True, "whether people may play on the pages, with or without a token as `anonymous` says")
    play_image_sizes: tuple[int, ...] = setting(
        (448, 224),
        "image side lengths for people who play on the pages: the first, and the last over a slow connection",
        unit="pixels",
        least=64,
        most=1024,
    )
    play_landing_diagram: bool = setting(
        False, "whether people see a diagram of the room with the cell in which they would place the object"
    )
    play_frame_strip: bool = setting(False, "whether people see their last frames beside the current one")
    play_compass: bool = setting(False, "whether people see their heading relative to the start of the phase")
    play_look_around: bool = setting(False, "whether people may look in other directions without steps")
    play_zoom: bool = setting(False, "whether people may magnify what they see")
    play_pictured_names: bool = setting(
        False, "whether people see pictures of the things that instructions name, with their words in every language"
    )
    play_ahead: bool = setting(
        False, "whether people are told what a pick-up would take, and in the room the cell ahead and what is on it"
    )
    play_scene_words: bool = setting(
        False,
        "whether people may ask what is visible, in words; their runs then have depth and segmentation, so it is left "
        "out on splits that do not offer these",
    )
    metrics: str = setting(
        "",
        "address of the metrics, which may equal `web`; empty: the same as `web` if that is a loopback address, "
        "otherwise none",
        form=TCP_FORM,
        check=is_tcp_address,
        of_public_server=True,
    )
    host_name: str = setting("", "name of the host, which the pages show", form=LINE, check=is_line)
    host_contact: str = setting(
        "",
        "how to contact the host, which the pages show: a mail address, or the address of a page",
        form=LINE,
        check=is_line,
    )
    host_rules: str = setting(
        "",
        "rules of the leaderboard, or the address of a page with them, which the pages show",
        form=LINE,
        check=is_line,
    )
    closes: SplitTimes = setting(
        NO_TIMES,
        "closing times of the splits' leaderboards: from then on no runs on them are created or published",
        of_public_server=True,
    )
    frozen: bool = setting(
        False,
        "whether leaderboards with a closing time show scores only to a run's own participant and to hosts until then",
        of_public_server=True,
    )
    drain_seconds: float = setting(
        10.0,
        "time in which open calls may end after the server has received a signal to stop",
        unit="seconds",
        least=0.0,
        most=3600.0,
    )
    log: str = setting("warning", "lowest level that is logged", choices=("debug", "info", "warning", "error"))
    log_format: str = setting(
        "text", "format of the log: a line of text or a JSON object for each event", choices=("text", "json")
    )
    embedded: bool = setting(
        False, "whether a client runs the server for itself alone; see `of_public_server`", internal=True
    )
    shared_port: bool = setting(False, "whether other processes may listen on the same ports", internal=True)
    own_address: str = setting(
        "", "a second address, which only this process listens on", form=FORM, check=is_address, internal=True
    )

    def __post_init__(self) -> None:
        problem = problem_of_camera(self.camera)
        if problem:
            raise ContradictorySettings(f"camera is {self.camera!r}, {problem}", "camera")
        for present, absent in (("tls_certificate", "tls_key"), ("tls_key", "tls_certificate")):
            if getattr(self, present) is not None and getattr(self, absent) is None:
                raise ContradictorySettings(
                    f"{present} is set but {absent} is not; expected both or neither", present, absent
                )
        for name in ("web", "metrics"):
            address = getattr(self, name)
            if address and address == self.listen and not address.endswith(":0"):
                raise ContradictorySettings(
                    f"{name} and listen are both {address}; expected different ones", name, "listen"
                )
        if self.frozen and not self.closes.named:
            raise ContradictorySettings(
                "frozen is set but closes is not; expected the time at which scores are shown", "frozen"
            )

    @property
    def is_for_own_machine(self) -> bool:
        """Whether only this machine can reach the server: on a loopback address or Unix socket, without a proxy."""
        return is_loopback(self.listen) and not self.trust_proxy

    @property
    def limits(self) -> Limits:
        """Limits of new runs."""
        return Limits(self.steps)

    @property
    def clocks(self) -> ClockSettings:
        """Clocks of new runs."""
        return ClockSettings(self.step_seconds, self.bank_seconds) if self.step_seconds else ClockSettings()

    @property
    def note_limits(self) -> NoteLimits:
        """Limits of the notes that agents leave beside their steps."""
        return NoteLimits(self.note_bytes, self.run_note_bytes)

    @property
    def journal_url(self) -> str:
        """URL of the journal's database."""
        return self.journal or f"sqlite:///{self.data.absolute() / 'journal.db'}"

    @property
    def signing_key_path(self) -> Path:
        """File of the key that signs receipts."""
        return self.signing_key or self.data / "signing-key.pem"

    @property
    def metrics_address(self) -> str:
        """Address of the metrics; empty if they are not served."""
        return self.metrics or (self.web if self.web and is_loopback(self.web) else "")

    @property
    def http(self) -> dict[str, str]:
        """URLs of "pages" and "metrics", if they are served, by name."""
        scheme = "https" if self.tls_certificate else "http"
        places = {"pages": self.web, "metrics": self.metrics_address}
        return {name: f"{scheme}://{address}" for name, address in places.items() if address}


SETTINGS = settings_of(Config)
"""Settings by name, in order of definition."""
