"""The server on which an adapter plays, and the runs that it creates there."""

import threading
from typing import Any, Unpack

from arramon.v1 import evaluation_pb2
from arramon_client.errors import UsageError
from arramon_client.run_settings import choose_split
from arramon_client.runs.connection import Connection
from arramon_client.runs.listing import listed_episodes
from arramon_client.runs.options import CreateOptions, ServerOptions

SERVER_OPTIONS = frozenset(ServerOptions.__annotations__)


class Host:
    """A server, remote or embedded, with the split and language that an adapter plays there. Thread-safe.

    Args:
        language: language of the instructions.
        agent: name of the agent, shown on the leaderboard.
        options: further options of runs, such as `split` and `sensors`, see `CreateOptions`. Without `server` an
            embedded server is started when it is needed, and shared by all runs.
    """

    def __init__(self, *, language: str, agent: str, **options: Unpack[CreateOptions]) -> None:
        self.language, self.agent = language, agent
        self._options = options
        self._lock = threading.Lock()
        self._connection: Connection | None = None

    @property
    def split(self) -> str:
        """Name of the split."""
        return self._description().name

    @property
    def is_hidden(self) -> bool:
        """Whether the split is hidden, so that it is played whole, and discloses no scores of single episodes."""
        return self._description().hidden

    @property
    def episode_count(self) -> int:
        """Number of the split's episodes in the language."""
        return self._description().episodes[self.language]

    def episodes(self) -> dict[str, str]:
        """Return the section of each episode, by episode id, in playing order.

        Raises:
            UsageError: if the split is hidden.
        """
        if self.is_hidden:
            raise UsageError(
                f"split {self.split!r} is hidden and can only be played whole; its episodes are not listed"
            )
        found = listed_episodes(self._connected().server, self.split, self.language)
        return {episode.episode_id: episode.section for episode in found}

    def server_options(self) -> ServerOptions:
        """Return the options with which runs reach the server."""
        given: Any = self._server_given()
        if given.get("server") is None:
            given.pop("data", None)
            given["server"] = self._connected().server.address
        return given  # type: ignore[no-any-return]

    def run_options(self, episode_id: str | None) -> CreateOptions:
        """Return the options of a run of one episode; None for all."""
        options: Any = {**self._run_options(), **self.server_options(), "split": self.split}
        return options | ({} if episode_id is None else {"episode_ids": (episode_id,)})  # type: ignore[no-any-return]

    def with_choice(self, language: str, split: str) -> "Host":
        """Return the same server with another choice; an embedded one is stopped by closing this host."""
        options: Any = {**self._run_options(), **self.server_options()}
        return Host(language=language, agent=self.agent, **options | {"split": split})

    def close(self) -> None:
        """Close the connection, and stop an embedded server; a second call does nothing."""
        with self._lock:
            connection, self._connection = self._connection, None
        if connection is not None:
            connection.close()

    def _server_given(self) -> ServerOptions:
        given: Any = {name: value for name, value in self._options.items() if name in SERVER_OPTIONS}
        return given  # type: ignore[no-any-return]

    def _run_options(self) -> dict[str, Any]:
        return {name: value for name, value in self._options.items() if name not in SERVER_OPTIONS}

    def _description(self) -> evaluation_pb2.Split:
        return choose_split(self._connected().server.info, self.language, self._options.get("split"))

    def _connected(self) -> Connection:
        with self._lock:
            if self._connection is None:
                self._connection = Connection(self._server_given(), needs_episodes=not self._options.get("split"))
            return self._connection
