"""From what the runs know to messages on the wire, one function a noun."""

from collections.abc import Mapping
from dataclasses import asdict

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from server.episodes.episode import Episode
from server.episodes.splits import Split
from server.runs.callers import Caller
from server.runs.clocks import Clocks
from server.runs.quotas import Quota
from server.runs.receipts import Receipt
from server.runs.records import Ending, Progress, Run
from server.runs.reports import Report
from server.runs.usage import Use
from server.scoring.aggregate import Interval
from server.sim.geometry import AGENT_RADIUS, Pose
from server.sim.labels import LABELS
from server.sim.room import Placement
from server.sim.rules import Action, Phase
from server.sim.scene import Scene

ACTIONS = {
    Action.FORWARD: types_pb2.ACTION_FORWARD,
    Action.LEFT: types_pb2.ACTION_LEFT,
    Action.RIGHT: types_pb2.ACTION_RIGHT,
    Action.INTERACT: types_pb2.ACTION_INTERACT,
}
LABEL_MESSAGES = tuple(pb.Label(kind=label.kind, colour=label.colour, look=label.look) for label in LABELS)
"""What the numbers of a segmentation mean."""

PHASES = {Phase.NAVIGATION: types_pb2.PHASE_NAVIGATION, Phase.ASSEMBLY: types_pb2.PHASE_ASSEMBLY}


def run_message(run: Run, progress: Progress) -> pb.Run:
    """A run and how far it is."""
    return pb.Run(
        run_id=run.run_id,
        participant=run.participant,
        agent=run.agent,
        split=run.split,
        language=run.language,
        sensors=run.sensors,
        limits=limits_message(run.steps_per_phase, Clocks.of(run)),
        data_hash=run.data_hash,
        state=pb.RunState.Value(f"RUN_STATE_{run.state}"),
        episodes=progress.episodes,
        episodes_ended=progress.ended,
        steps=progress.steps,
        causes=progress.causes,
        images=progress.images,
        created_at=run.created_at.isoformat(timespec="seconds"),
        ended_at=run.ended_at.isoformat(timespec="seconds") if run.ended_at else "",
        reoffers=progress.reoffers,
        bank_seconds_left=run.bank_left,
        published=progress.published,
    )


def limits_message(steps_per_phase: int, clocks: Clocks) -> types_pb2.Limits:
    """What a run is granted."""
    return types_pb2.Limits(
        steps_per_phase=steps_per_phase,
        step_seconds=clocks.step_seconds,
        first_step_seconds=clocks.first_step_seconds,
        bank_seconds=clocks.bank_seconds,
    )


def split_message(split: Split) -> pb.Split:
    """A split as the server's information shows it."""
    return pb.Split(
        name=split.name,
        hidden=split.hidden,
        episodes=split.languages,
        sensors=split.sensors,
        data_hash=split.data_hash,
    )


def account_message(caller: Caller, standings: Mapping[str, tuple[Quota, Use]]) -> pb.Account:
    """Whom the server takes a caller for, with their limits on each split, and what counts against them."""
    quotas = [pb.Quota(split=split, **asdict(quota), **asdict(use)) for split, (quota, use) in standings.items()]
    role = pb.Role.Value(f"ROLE_{caller.role.name}")
    return pb.Account(participant=caller.account or "", role=role, quotas=quotas)


def report_message(report: Report) -> pb.Report:
    """The scores of a run."""
    return pb.Report(
        run=run_message(report.run, report.progress),
        signature=report.signature,
        rows=[row_message(name, intervals) for name, intervals in report.table.rows.items()],
        episodes=[_episode_scores(ending) for ending in report.endings],
    )


def receipt_message(receipt: Receipt) -> pb.Receipt:
    """What the host vouches for."""
    return pb.Receipt(payload=receipt.payload, signature=receipt.signature, public_key=receipt.public_key)


def pose_message(pose: Pose) -> types_pb2.Pose:
    """A pose."""
    return types_pb2.Pose(x=pose.x, z=pose.z, heading=pose.heading)


def cell_message(cell: Placement) -> types_pb2.Cell:
    """A place in the room."""
    return types_pb2.Cell(column=cell.column, level=cell.level, row=cell.row)


def oracle_message(episode: Episode, scene: Scene) -> pb.Oracle:
    """What only a privileged agent may know: the ground truth, and what is solid in the scene."""
    obstacles = [
        pb.Obstacle(
            x=body.position[0],
            z=body.position[1],
            half_width=body.collider.half_width,
            half_length=body.collider.half_length,
            heading=body.heading,
        )
        for body in scene.bodies
        if body.collider is not None
    ]
    room = [decoy.placement for decoy in episode.decoys]
    targets = []
    for turn in episode.turns:
        x, y, z = turn.target.position
        targets.append(
            pb.Target(
                position=types_pb2.Position(x=x, y=y, z=z),
                cell=cell_message(turn.target_cell),
                occupied=[cell_message(cell) for cell in room],
            )
        )
        room.append(turn.target_cell)
    return pb.Oracle(start=pose_message(episode.start), agent_radius=AGENT_RADIUS, obstacles=obstacles, targets=targets)


def row_message(name: str, intervals: Mapping[str, Interval]) -> pb.Row:
    """A row of a score table."""
    scores = [pb.Score(metric=metric, mean=i.mean, low=i.low, high=i.high) for metric, i in intervals.items()]
    return pb.Row(name=name, scores=scores)


def _episode_scores(ending: Ending) -> pb.EpisodeScores:
    turns = [
        row_message(f"turn {number}", {metric: Interval(value, value, value) for metric, value in scores.items()})
        for number, scores in enumerate(ending.scores, start=1)
    ]
    cause = types_pb2.Cause.Value(f"CAUSE_{ending.cause}")
    return pb.EpisodeScores(episode_id=ending.episode_id, cause=cause, turns=turns, steps=ending.steps)
