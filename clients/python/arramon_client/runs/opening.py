"""Creating and resuming runs: the connection, the request, and the start of the stream."""

import logging
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TypeVar

from arramon.v1 import evaluation_pb2
from arramon_client import receipts, run_settings
from arramon_client.errors import UsageError
from arramon_client.local.embedded_play import embedded_for_play
from arramon_client.receipts import Receipt
from arramon_client.runs.info import RunInfo, info_of
from arramon_client.runs.listing import listed_runs
from arramon_client.runs.live import LiveRun
from arramon_client.runs.options import CreateOptions, PlayOptions, ServerOptions
from arramon_client.settings import Settings
from arramon_client.transport.access import Access, make_access
from arramon_client.transport.connection import Server, call, connect, raise_unreachable
from arramon_client.transport.incoming import RUN_ID, check_same_run
from arramon_client.transport.retry import PATIENCE, Retry, call_until_answered
from arramon_client.world import DEFAULT_SENSORS

Answer = TypeVar("Answer")

_log = logging.getLogger("arramon_client.runs")

CODE = ("url", "commit", "image")
"""Keys of the option `code`."""


class Connection:
    """A connected server, remote or embedded.

    Args:
        options: the server.
        needs_episodes: whether an embedded server without episodes must generate some.
        resumes: the run that is resumed, whose server may be restarting; empty for a new one.
        patience: seconds to wait for that server.

    Raises:
        ArramonClientError: if the server cannot be reached or started, or refuses.

    Attributes:
        server: the server.
        revive: restarts an embedded server that has died.
        notify: called with messages for the participant.
    """

    def __init__(
        self, options: ServerOptions, *, needs_episodes: bool = False, resumes: str = "", patience: float = PATIENCE
    ) -> None:
        self.notify = options.get("notify") or _log.warning
        self.revive: Callable[[], None] = lambda: None
        self._stack = ExitStack()
        try:
            address, access, unreachable = options.get("server"), Access(), raise_unreachable
            data, tls_ca = options.get("data"), options.get("tls_ca")
            if address is None:
                embedded = self._stack.enter_context(
                    embedded_for_play(
                        None if data is None else Path(data), self.notify, needs_episodes=needs_episodes, quiet=True
                    )
                )
                address, self.revive = embedded.address, embedded.revive
            else:
                if data is not None:
                    raise UsageError("data applies to the embedded server, and cannot be used together with server")
                access = make_access(
                    options.get("token"), tls=options.get("tls"), tls_ca=None if tls_ca is None else Path(tls_ca)
                )
                if resumes:
                    unreachable = Retry(resumes, patience, self.notify).wait_for
            self.server: Server = self._stack.enter_context(connect(address, access, unreachable=unreachable))
        except BaseException:
            self._stack.close()
            raise

    def close(self) -> None:
        """Close the connection, and stop an embedded server; a second call does nothing."""
        self._stack.close()


class OpenedRun:
    """A run that is being played, with its connection.

    Args:
        connection: the connection, which `close` closes.
        run: the run.
        settings: settings of the stream.
        replays: whether recorded steps are handed out.
    """

    def __init__(
        self, connection: Connection, run: evaluation_pb2.Run, settings: Settings, *, replays: bool = False
    ) -> None:
        self.connection, self.run_id = connection, run.run_id
        was_over = run.state != evaluation_pb2.RUN_STATE_RUNNING
        self.live = LiveRun(run, replays=replays, notify=connection.notify, was_over=was_over)
        self._patience = settings.patience
        if not was_over:
            self.live.start(connection.server.stub, settings, connection.server.address, connection.revive)

    def run(self) -> evaluation_pb2.Run:
        """Return the run as it is on the server now."""
        stub = self.connection.server.stub
        return self._read(stub.GetRun, evaluation_pb2.GetRunRequest(run_id=self.run_id))

    def cancel(self) -> evaluation_pb2.Run:
        """Cancel the run, and return it."""
        request = evaluation_pb2.CancelRunRequest(run_id=self.run_id)
        return call(self.connection.server.stub.CancelRun, request, self.connection.server.address)

    def report(self) -> evaluation_pb2.Report:
        """Return the run's scores.

        Raises:
            UsageError: if the run is not over.
        """
        self._check_over("scores")
        stub = self.connection.server.stub
        return self._read(stub.GetReport, evaluation_pb2.GetReportRequest(run_id=self.run_id))

    def receipt(self) -> Receipt:
        """Return the run's receipt, after verifying its signature and the server's key.

        Raises:
            UsageError: if the run is not over.
            ReceiptError: if it was altered, or signed with another key than the server's.
        """
        self._check_over("a receipt")
        server = self.connection.server
        message = self._read(server.stub.GetReceipt, evaluation_pb2.GetReceiptRequest(run_id=self.run_id))
        receipt = receipts.receipt_of(message, self.run_id)
        receipts.check_key(receipt, server.info.public_key, "the server's key")
        return receipt

    def close(self) -> None:
        """Close the streams and the connection; the run stays as it is on the server."""
        self.live.close()
        self.connection.close()

    def _check_over(self, wanted: str) -> None:
        if not self.live.is_over:
            run = self.run()
            if run.state == evaluation_pb2.RUN_STATE_RUNNING:
                raise UsageError(
                    f"run {self.run_id} has {wanted} when it is over, but only {run.episodes_ended} of its "
                    f"{run.episodes} episodes have ended"
                )

    def _read(self, method: Callable[..., Answer], request: object) -> Answer:
        """Make a read-only call, until the server answers."""
        connection = self.connection
        retry = Retry(self.run_id, self._patience, connection.notify)
        answer = call_until_answered(method, request, connection.server.address, retry, connection.revive)
        run = getattr(answer, "run", answer)
        if isinstance(run, evaluation_pb2.Run):
            check_same_run(run, self.run_id)
        return answer


def create(language: str, agent: str, options: CreateOptions, parallel: int) -> OpenedRun:
    """Create a run, and start to play it.

    Args:
        language: language of the instructions.
        agent: name of the agent.
        options: the other options.
        parallel: the default of the option `parallel`.

    Raises:
        UsageError: if an option is wrong, or the server does not have what it names.
        ArramonClientError: if the server cannot be reached or started, or refuses.
    """
    _check_names(options, CreateOptions)
    connection = Connection(options, needs_episodes=not options.get("split"))
    try:
        server = connection.server
        request = _request(server, language, agent, options)
        settings = _settings(server, options, parallel, resumes=False)  # Fail before a run is created.
        run = call(server.stub.CreateRun, request, server.address)
        return OpenedRun(connection, run, settings)
    except BaseException:
        connection.close()
        raise


def resume(run_id: str, options: PlayOptions, parallel: int, *, history: bool) -> OpenedRun:
    """Resume a run, and start to play it.

    Args:
        run_id: id of the run.
        options: server and settings.
        parallel: the default of the option `parallel`.
        history: whether recorded steps are handed out.

    Raises:
        ArramonClientError: as for `create`; also if there is no such run.
    """
    _check_names(options, PlayOptions)
    if not RUN_ID.fullmatch(run_id):
        raise UsageError(f"{run_id!r} is not the id of a run, expected 32 hexadecimal digits")
    patience = options.get("patience", PATIENCE)
    connection = Connection(options, resumes=run_id, patience=patience)
    try:
        server = connection.server
        retry = Retry(run_id, patience, connection.notify)
        run = call_until_answered(
            server.stub.GetRun, evaluation_pb2.GetRunRequest(run_id=run_id), server.address, retry, connection.revive
        )
        check_same_run(run, run_id)
        return OpenedRun(connection, run, _settings(server, options, parallel, resumes=True), replays=history)
    except BaseException:
        connection.close()
        raise


def _request(server: Server, language: str, agent: str, options: CreateOptions) -> evaluation_pb2.CreateRunRequest:
    split = run_settings.choose_split(server.info, language, options.get("split"))
    code = options.get("code")
    if code is not None and not set(code) <= set(CODE):
        raise UsageError(f"code has the keys {', '.join(code)}, expected some of {', '.join(CODE)}")
    return evaluation_pb2.CreateRunRequest(
        agent=agent,
        split=split.name,
        language=language,
        sensors=run_settings.check_sensors(options.get("sensors", DEFAULT_SENSORS), split),
        episodes=options.get("episodes", 0),
        episode_ids=options.get("episode_ids", ()),
        participant=options.get("participant", ""),
        agent_arguments=[
            evaluation_pb2.AgentArgument(name=name, value=str(value))
            for name, value in options.get("agent_arguments", {}).items()
        ],
        code=None if not code else evaluation_pb2.Code(**code),
    )


def _settings(server: Server, options: PlayOptions, parallel: int, *, resumes: bool) -> Settings:
    encoding = options.get("encoding")
    if encoding is not None and encoding not in run_settings.ENCODINGS:
        raise UsageError(f"encoding is {encoding!r}, expected one of {', '.join(run_settings.ENCODINGS)}")
    chosen = run_settings.choose_encoding(server.info, encoding, server.address)
    parallel = min(parallel, server.info.max_episodes_per_stream or parallel)
    return Settings(
        parallel=run_settings.choose_parallel(server.info, options.get("parallel") or parallel),
        encoding=chosen,
        jpeg_quality=run_settings.choose_jpeg_quality(chosen, options.get("jpeg_quality")),
        image_size=run_settings.choose_image_size(server.info, options.get("image_size") or None),
        resume=resumes,
        patience=options.get("patience", PATIENCE),
    )


def _check_names(options: ServerOptions, expected: type) -> None:
    unknown = sorted(options.keys() - expected.__optional_keys__)  # type: ignore[attr-defined]  # of a TypedDict
    if unknown:
        known = ", ".join(sorted(expected.__optional_keys__))  # type: ignore[attr-defined]
        raise UsageError(f"unknown option {', '.join(unknown)}; expected some of {known}")


def list_runs(options: ServerOptions) -> list[RunInfo]:
    """Return the runs that the caller may see, latest first; errors as for `create`."""
    _check_names(options, ServerOptions)
    connection = Connection(options)
    try:
        return [info_of(run) for run in listed_runs(connection.server)]
    finally:
        connection.close()
