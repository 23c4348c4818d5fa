"""Options with which a run is created or resumed."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TypedDict


class ServerOptions(TypedDict, total=False):
    """The server on which a run is played.

    Keys:
        server: address, `host:port` or `unix:/path`; None (default) to start an embedded server.
        data: data folder of the embedded server; None (default) for `$ARRAMON_DATA`, or `arramon-data` in the working
            directory.
        token: the participant's token; None (default) for the environment variable `ARRAMON_TOKEN`, if it is set.
        tls: whether to encrypt the connection; None (default): if a token leaves this machine.
        tls_ca: file with PEM certificates to trust in place of public authorities.
        notify: called with messages for the participant, such as a lost connection, from other threads; by default
            they are logged as `arramon_client.runs`.
    """

    server: str | None
    data: Path | str | None
    token: str | None
    tls: bool | None
    tls_ca: Path | str | None
    notify: Callable[[str], None]


class PlayOptions(ServerOptions, total=False):
    """How a run is played.

    Keys:
        parallel: largest number of episodes that are open at once: 1 for `Run`, 8 for `AsyncRun` by default. On a host
            with clocks an open episode must be acted on in time.
        encoding: encoding of images: "shared", "raw", "zstd" or "jpeg"; None (default) for the fastest lossless one.
        jpeg_quality: 1 to 100, with "jpeg" only; None (default) for the server's.
        image_size: side length of images in pixels; None (default) for the server's.
        patience: seconds to keep reconnecting while the server is away, 300 by default.
    """

    parallel: int | None
    encoding: str | None
    jpeg_quality: int | None
    image_size: int | None
    patience: float


class CreateOptions(PlayOptions, total=False):
    """What a run plays.

    Keys:
        split: the split; None (default) for the server's only split with the language.
        sensors: sensors of the observations, `("rgb", "depth")` by default; () for none.
        episodes: number of episodes, from the start of the split's fixed order; 0 (default) for all.
        episode_ids: play only these episodes, in this order; open splits only.
        participant: name of a participant without a token.
        agent_arguments: arguments of the agent, by name: text, or a value to write as JSON, as in `--agent-arg`;
            published with the run.
        code: where the agent's code can be found: any of "url", "commit" and "image"; published with the run.
    """

    split: str | None
    sensors: Sequence[str]
    episodes: int
    episode_ids: Sequence[str]
    participant: str
    agent_arguments: Mapping[str, object]
    code: Mapping[str, str] | None
