"""A scripted server: episodes with a fixed number of steps, a journal that outlives the server, and injected faults."""

# ruff: noqa: N802 - the methods are named by the protocol

import threading
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

import grpc

from arramon.v1 import PROTOCOL, evaluation_pb2, types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationServicer, add_EvaluationServicer_to_server

pb = evaluation_pb2
RUN = "1f" * 16
"""The id of every run here."""

METRICS = ("nDTW", "CTC-0", "CTC-3", "CTC-5", "CTC-7", "rPOD@CTC-3", "PTC@CTC-3", "rPOD", "PTC")


class Broken(Exception):
    """Raised where the connection must be cut."""


class World:
    """What the server knows, and what happened to it.

    Attributes:
        actions: recorded actions by episode.
        reasons: of forfeited episodes.
        causes: of ended episodes.
        requests: every run that was asked for.
        opens: every `Open` that came.
        batches: acts in each action message.
        cut: numbers of acts, counted over all, at which the stream is cut: "before" or "after" the act is recorded.
        cancelled: runs, as they were named.
        problems: numbers of acts that are answered with a problem of this code, and not recorded.
        away: by method, for how many calls there is to be no server.
        draining: by method, how many calls reach a process that drains, which cancels them.
        unopened: statuses with which the next streams end before anything is sent; None for an end without an error.
        notes: recorded notes, by episode and step.
    """

    def __init__(self, episodes: int = 4, steps: int = 5) -> None:
        self.info = pb.ServerInfo(
            version="9.9.9",
            protocol=PROTOCOL,
            splits=[
                pb.Split(name="val_seen", episodes={"en": episodes}, sensors=["rgb", "depth", "segmentation", "pose"])
            ],
            encodings=[types_pb2.ENCODING_RAW, types_pb2.ENCODING_ZSTD],
            image_sizes=[64, 128],
            max_episodes_per_stream=32,
        )
        self.run = pb.Run()
        self.requests: list[pb.CreateRunRequest] = []
        self.cancelled: list[str] = []
        self.steps = steps
        self.order = [f"e{i}" for i in range(episodes)]
        self.actions: dict[str, list[int]] = {}
        self.reasons: dict[str, str] = {}
        self.causes: dict[str, types_pb2.Cause.ValueType] = {}
        self.players: dict[str, str] = {}
        self.opens: list[pb.Open] = []
        self.batches: list[int] = []
        self.cut: dict[int, str] = {}
        self.problems: dict[int, pb.Problem.Code.ValueType] = {}
        self.away = Counter[str]()
        self.draining = Counter[str]()
        self.unopened: list[grpc.StatusCode | None] = []
        self.notes: dict[tuple[str, int], str] = {}
        self.acts = 0
        self.lock = threading.RLock()

    def create(self, request: pb.CreateRunRequest) -> pb.Run:
        """The one run."""
        self.run = pb.Run(
            run_id=RUN,
            agent=request.agent,
            split=request.split,
            language=request.language,
            sensors=request.sensors,
            participant=request.participant,
            state=pb.RUN_STATE_RUNNING,
            episodes=len(self.order),
            agent_arguments=request.agent_arguments,
            code=request.code if request.HasField("code") else None,
        )
        self.requests.append(request)
        return self.run

    def current_run(self) -> pb.Run:
        """The run as it stands."""
        self.run.episodes_ended = len(self.causes)
        self.run.steps = sum(map(len, self.actions.values()))
        if len(self.causes) == len(self.order):
            self.run.state = pb.RUN_STATE_COMPLETE
        return self.run

    def opened(self, opening: pb.Open) -> list[pb.Event]:
        """The first events of a stream."""
        self.opens.append(opening)
        for episode_id in self.players:
            if opening.adopt:
                self.players[episode_id] = opening.player
        mine = [e for e, player in self.players.items() if player == opening.player and e not in self.causes]
        labels = LABELS if "segmentation" in self.run.sensors else ()
        events = [pb.Event(opened=pb.Opened(run=self.current_run(), episode_ids=mine, labels=labels))]
        if opening.encoding == types_pb2.ENCODING_SHARED:
            events[0].opened.encoding = opening.encoding
            events[0].opened.shared.CopyFrom(types_pb2.SharedMemory(process=1 << 31, descriptor=3, size=9, token=b"t"))
        for episode_id in mine:
            events += self.started(episode_id, history=opening.history)
        return events + self.offered(opening)

    def offered(self, opening: pb.Open) -> list[pb.Event]:
        """New episodes, up to what the player asked for; or the end of the run."""
        events: list[pb.Event] = []
        for episode_id in self.order:
            open_ = [e for e, p in self.players.items() if p == opening.player and e not in self.causes]
            if episode_id not in self.players and len(open_) < opening.max_episodes:
                self.players[episode_id] = opening.player
                self.actions[episode_id] = []
                events += self.started(episode_id, history=opening.history)
        if len(self.causes) == len(self.order):
            events.append(pb.Event(run_ended=pb.RunEnded(run=self.current_run())))
        return events

    def started(self, episode_id: str, *, history: bool) -> list[pb.Event]:
        """An episode's start and its latest observation, or all of them."""
        taken = self.actions[episode_id]
        start = pb.EpisodeStarted(episode_id=episode_id, language="en", split="val_seen", step=len(taken))
        past = [self.observation(episode_id, step, action) for step, action in enumerate(taken)] if history else []
        return [pb.Event(episode_started=start), *past, self.observation(episode_id, len(taken))]

    def observation(self, episode_id: str, step: int, taken: int | None = None) -> pb.Event:
        """What is seen at a step."""
        message = pb.Observation(
            episode_id=episode_id, step=step, turn=1, phase=types_pb2.PHASE_NAVIGATION, instruction=f"go {step}",
            phase_step=step, steps_left=self.steps - step, rgb=RGB, depth=DEPTH,
        )  # fmt: skip
        if "segmentation" in self.run.sensors:
            message.segmentation.CopyFrom(SEGMENTATION)
        if taken is not None:
            message.taken = types_pb2.Action.ValueType(taken)
            if (episode_id, step) in self.notes:
                message.taken_note = self.notes[episode_id, step]
        return pb.Event(observation=message)

    def act(self, act: pb.Act, opening: pb.Open) -> list[pb.Event]:
        """What follows from an act."""
        self.acts += 1
        number, episode_id = self.acts, act.episode_id
        if number in self.problems:
            problem = pb.Problem(code=self.problems[number], message="no", episode_id=episode_id, step=act.step)
            return [pb.Event(problem=problem)]
        if self.cut.get(number) == "before":
            raise Broken
        taken = self.actions[episode_id]
        if self.players[episode_id] != opening.player or episode_id in self.causes:
            problem = pb.Problem(code=pb.Problem.CODE_NOT_YOUR_EPISODE, message="not yours", episode_id=episode_id)
            return [pb.Event(problem=problem)]
        if act.WhichOneof("choice") == "forfeit":
            self.reasons[episode_id] = act.forfeit.reason
            return self.ended(episode_id, types_pb2.CAUSE_FORFEITED, opening)
        if act.step < len(taken):
            assert taken[act.step] == act.action, "a step was answered twice, and otherwise"
        else:
            assert act.step == len(taken), "a step ahead of its turn"
            taken.append(act.action)
            if act.note:
                self.notes[episode_id, act.step] = act.note
        if len(taken) == self.steps:
            events = self.ended(episode_id, types_pb2.CAUSE_AGENT_FINISHED, opening)
        else:
            events = [self.observation(episode_id, len(taken))]
        if self.cut.get(number) == "after":
            raise Broken
        return events

    def ended(self, episode_id: str, cause: types_pb2.Cause.ValueType, opening: pb.Open) -> list[pb.Event]:
        """An episode's end, and what is offered in its place."""
        self.causes[episode_id] = cause
        end = pb.EpisodeEnded(episode_id=episode_id, cause=cause, episodes_ended=len(self.causes))
        return [pb.Event(episode_ended=end), *self.offered(opening)]

    def report(self) -> pb.Report:
        """A report with made-up scores."""
        rows = [
            pb.Row(name=name, scores=[pb.Score(metric=m, mean=0.25, low=0.125, high=0.5) for m in METRICS])
            for name in ("turn 1", "turn 2", "total")
        ]
        episodes = [pb.EpisodeScores(episode_id=e, cause=c, turns=rows[:2], steps=7) for e, c in self.causes.items()]
        return pb.Report(
            run=self.current_run(), signature="arramon 9.9.9 | val_seen | en", rows=rows, episodes=episodes
        )


RGB = types_pb2.Image(height=2, width=3, encoding=types_pb2.ENCODING_RAW, data=bytes(range(18)))
SEGMENTATION = types_pb2.Image(height=1, width=2, encoding=types_pb2.ENCODING_RAW, data=b"\1\0\0\0")
LABELS = (pb.Label(kind="nothing"), pb.Label(kind="mug", colour="red", look="dotted"))
DEPTH = types_pb2.Image(height=1, width=2, encoding=types_pb2.ENCODING_RAW, data=b"\xe8\x03\xff\xff")


class Servicer(EvaluationServicer):
    """Servicer of a world."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.metadata: list[dict[str, str | bytes]] = []

    def GetServerInfo(self, request: pb.GetServerInfoRequest, context: Any) -> pb.ServerInfo:
        self.metadata.append(dict(context.invocation_metadata()))
        self._be_away("GetServerInfo", context)
        return self.world.info

    def GetAccount(self, request: pb.GetAccountRequest, context: Any) -> pb.Account:
        return pb.Account(role=pb.ROLE_ANONYMOUS)

    def _be_away(self, method: str, context: Any) -> None:
        if self.world.away[method] > 0:
            self.world.away[method] -= 1
            context.abort(grpc.StatusCode.UNAVAILABLE, "away")
        if self.world.draining[method] > 0:
            self.world.draining[method] -= 1
            context.abort(grpc.StatusCode.CANCELLED, "CANCELLED")

    def GetReceipt(self, request: pb.GetReceiptRequest, context: Any) -> pb.Receipt:
        self._be_away("GetReceipt", context)
        context.abort(grpc.StatusCode.NOT_FOUND, "the fake server signs nothing")
        raise AssertionError

    def ListEpisodes(self, request: pb.ListEpisodesRequest, context: Any) -> pb.ListEpisodesResponse:
        return pb.ListEpisodesResponse()

    def CreateRun(self, request: pb.CreateRunRequest, context: Any) -> pb.Run:
        run = self.world.create(request)
        self._be_away("CreateRun", context)  # It may have come as far as this.
        return run

    def GetRun(self, request: pb.GetRunRequest, context: Any) -> pb.Run:
        self._be_away("GetRun", context)
        if request.run_id != self.world.run.run_id:
            context.abort(grpc.StatusCode.NOT_FOUND, f"there is no run {request.run_id!r}")
        return self.world.current_run()

    def ListRuns(self, request: pb.ListRunsRequest, context: Any) -> pb.ListRunsResponse:
        return pb.ListRunsResponse(runs=[self.world.run])

    def CancelRun(self, request: pb.CancelRunRequest, context: Any) -> pb.Run:
        self.world.cancelled.append(request.run_id)
        return self.world.run

    def GetReport(self, request: pb.GetReportRequest, context: Any) -> pb.Report:
        self._be_away("GetReport", context)
        return self.world.report()

    def ListNotes(self, request: pb.ListNotesRequest, context: Any) -> pb.ListNotesResponse:
        return pb.ListNotesResponse(
            notes=[
                pb.Note(episode_id=episode_id, step=step, text=text)
                for (episode_id, step), text in self.world.notes.items()
            ]
        )

    def GetBreakdown(self, request: pb.GetBreakdownRequest, context: Any) -> pb.Breakdown:
        context.abort(grpc.StatusCode.NOT_FOUND, "the fake server breaks nothing down")
        raise AssertionError

    def Play(self, requests: Iterator[pb.PlayRequest], context: Any) -> Iterator[pb.PlayResponse]:
        opening = next(requests).open
        if self.world.unopened:
            status = self.world.unopened.pop(0)
            if status is not None:
                context.abort(status, "draining")
            return
        with self.world.lock:
            events = self.world.opened(opening)
        yield pb.PlayResponse(events=events)
        for request in requests:
            answers: list[pb.Event] = []
            self.world.batches.append(len(request.actions.acts))
            for act in request.actions.acts:
                try:
                    with self.world.lock:
                        answers += self.world.act(act, opening)
                except Broken:
                    context.abort(grpc.StatusCode.UNAVAILABLE, "cut")
            yield pb.PlayResponse(events=answers)


@contextmanager
def serving(servicer: EvaluationServicer, address: str = "127.0.0.1:0") -> Iterator[str]:
    """Serve until the end of the context; yield the address."""
    pool = ThreadPoolExecutor(8)
    server = grpc.server(pool)
    add_EvaluationServicer_to_server(servicer, server)
    port = server.add_insecure_port(address)
    server.start()
    try:
        yield address if address.startswith("unix:") else f"127.0.0.1:{port}"
    finally:
        server.stop(None).wait()
        pool.shutdown()


class Recorder:
    """An agent that acts by a rule, and remembers what it was asked.

    Attributes:
        begun: episodes, in order.
        asked: (episode, step), in order.
        sizes: of the batches.
    """

    def __init__(self) -> None:
        self.begun: list[str] = []
        self.asked: list[tuple[str, int]] = []
        self.sizes: list[int] = []

    def begin(self, episode: Any) -> None:
        self.begun.append(episode.episode_id)

    def act(self, observations: Sequence[Any]) -> list[int]:
        self.sizes.append(len(observations))
        self.asked += [(observation.episode_id, observation.step) for observation in observations]
        return [self.rule(observation.episode_id, observation.step) for observation in observations]

    @staticmethod
    def rule(episode_id: str, step: int) -> int:
        return (int(episode_id[1:]) + step) % 4
