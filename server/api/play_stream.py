"""The handler of one Play stream, between the client's messages and the engine."""

import asyncio
import uuid
from collections.abc import AsyncGenerator, AsyncIterator

from arramon.v1 import evaluation_pb2 as pb
from arramon_server.api.encoding_choice import choose_encoder, offered_encodings
from arramon_server.api.event_sender import EventSender
from arramon_server.api.shared_memory import IMAGE_SENSORS
from arramon_server.configuration.config import Config
from arramon_server.errors import ArraMonError, BadInput
from arramon_server.image_threads import ImageThreads
from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.play.stream import Act, Stream
from arramon_server.runs.run_service import RunService
from arramon_server.visible_text import is_visible, shown

MAX_ACTS = 4096
"""Limit of acts in one message, four for each episode that a stream can have open: no message may delay all others."""


LONGEST_REASON = 500
"""Characters that are kept of the reason for giving up an episode; it is a note for the host."""


class PlayHandler:
    """Serves one Play stream.

    Args:
        open_: the client's first message.
        caller: the authenticated caller.
        runs: finds the run.
        engine: plays it.
        config: the server's settings.
        threads: in which images are compressed.

    Raises:
        ArraMonError: if the run cannot be played, or a field of `open_` is not allowed.
    """

    def __init__(
        self,
        open_: pb.Open,
        caller: Caller,
        runs: RunService,
        engine: Engine,
        config: Config,
        threads: ImageThreads,
    ) -> None:
        self._engine = engine
        if open_.image_size and open_.image_size not in config.image_sizes:
            sizes = ", ".join(map(str, config.image_sizes))
            raise BadInput(f"image_size is {open_.image_size}, expected one of {sizes}")
        if not 1 <= open_.max_episodes <= config.max_episodes_per_stream:
            raise BadInput(f"max_episodes is {open_.max_episodes}, expected 1 to {config.max_episodes_per_stream}")
        if len(open_.player) > 100:
            raise BadInput(f"the player's name has {len(open_.player)} characters; at most 100 are allowed")
        if not is_visible(open_.player):
            raise BadInput(f"the player's name is {open_.player!r}, expected visible text")
        run, size = runs.playable_run(caller, open_.run_id), open_.image_size or config.image_sizes[0]
        image_sensors = [name for name in IMAGE_SENSORS if name in run.sensors]
        self._encoder = choose_encoder(
            open_.encoding,
            open_.jpeg_quality,
            offered_encodings(config.listen),
            episodes=open_.max_episodes,
            sensors=run.sensors,
            size=size,
        )
        self._sender = EventSender(self._encoder, image_sensors, size, threads)
        self._stream = Stream(
            run=run,
            player=open_.player or uuid.uuid4().hex,
            max_episodes=open_.max_episodes,
            image_size=size,
            images=f"{self._encoder.image_quality}-{size}" if image_sensors else "",
            history=open_.history,
            adopt=open_.adopt,
            transport=self._sender,
        )

    @property
    def stream(self) -> Stream:
        """The stream, as the engine handles it."""
        return self._stream

    async def serve(self, requests: AsyncIterator[pb.PlayRequest]) -> AsyncGenerator[bytes]:
        """Yield responses in their wire format until the run ends, the client leaves, or an error closes the stream.

        Raises:
            ArraMonError: the error that closed the stream.
        """
        with self._encoder:
            reader = asyncio.create_task(self._read(requests))
            try:
                self._engine.join(self._stream)
                while (response := await self._sender.next_response()) is not None:
                    yield response
                    self._sender.note_sent(response)
                    self._engine.wake()
            finally:
                self._engine.leave(self._stream)
                reader.cancel()

    async def _read(self, requests: AsyncIterator[pb.PlayRequest]) -> None:
        """Pass the client's messages to the engine. A client that closes its half of the stream has left."""
        try:
            async for request in requests:
                self._engine.receive(self._stream, _acts(request))
                await self._stream.wait_for_space()
        except ArraMonError as error:
            self._sender.close(error)
        else:
            self._sender.close(None)


def _acts(request: pb.PlayRequest) -> list[Act]:
    """Return the acts of a message that follows a stream's first one.

    Raises:
        BadInput: if the message is not `actions`, or holds too many acts.
    """
    if request.WhichOneof("message") != "actions":
        raise BadInput("a stream's first message is `open`, every further one is `actions`")
    if len(request.actions.acts) > MAX_ACTS:
        raise BadInput(f"a message holds {len(request.actions.acts)} acts; at most {MAX_ACTS} are allowed")
    return [_act(act) for act in request.actions.acts]


def _act(act: pb.Act) -> Act:
    choice = act.WhichOneof("choice")
    return Act(
        act.episode_id,
        act.step,
        action=act.action if choice == "action" else None,
        forfeit=shown(act.forfeit.reason[:LONGEST_REASON]) if choice == "forfeit" else None,
        note=act.note,
    )
