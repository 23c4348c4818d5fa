"""Conversion of the server's objects to protocol messages, one function for each message type."""

from collections.abc import Mapping
from dataclasses import asdict
from datetime import datetime

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client.world import AGENT_RADIUS, Action
from arramon_server.closing_times import NEVER_CLOSES, ClosingTimes
from arramon_server.configuration.config import Config
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split
from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.accounts.quotas import Quota
from arramon_server.runs.accounts.usage import Usage
from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.results.breakdown import Breakdown
from arramon_server.runs.results.receipts import SignedReceipt
from arramon_server.runs.results.reports import Report
from arramon_server.runs.storage.records import EpisodeEnding, Run, RunProgress
from arramon_server.scoring.aggregate import Interval
from arramon_server.sim.geometry import Pose
from arramon_server.sim.labels import LABELS
from arramon_server.sim.room import RoomPosition
from arramon_server.sim.rules import Phase
from arramon_server.sim.scene import Scene

ACTIONS = {
    Action.FORWARD: types_pb2.ACTION_FORWARD,
    Action.LEFT: types_pb2.ACTION_LEFT,
    Action.RIGHT: types_pb2.ACTION_RIGHT,
    Action.INTERACT: types_pb2.ACTION_INTERACT,
}
LABEL_MESSAGES = tuple(pb.Label(kind=label.kind, colour=label.colour, look=label.look) for label in LABELS)
"""Messages of the segmentation labels, by number."""

PHASES = {Phase.NAVIGATION: types_pb2.PHASE_NAVIGATION, Phase.ASSEMBLY: types_pb2.PHASE_ASSEMBLY}


def run_message(run: Run, progress: RunProgress) -> pb.Run:
    """Return the message for a run and its progress."""
    return pb.Run(
        run_id=run.run_id,
        participant=run.participant,
        agent=run.agent,
        split=run.split,
        language=run.language,
        sensors=run.sensors,
        limits=limits_message(run.steps_per_phase, ClockSettings.of(run)),
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
        agent_arguments=[pb.AgentArgument(name=name, value=value) for name, value in run.agent_arguments],
        code=pb.Code(**run.code.named()) if run.code else None,
        thinking_seconds=progress.thinking_seconds,
        timed_steps=progress.timed_steps,
    )


def limits_message(steps_per_phase: int, clocks: ClockSettings) -> types_pb2.Limits:
    """Return the message for a run's step limit and clocks."""
    return types_pb2.Limits(
        steps_per_phase=steps_per_phase,
        step_seconds=clocks.step_seconds,
        bank_seconds=clocks.bank_seconds,
    )


def host_message(config: Config) -> pb.Host | None:
    """Return the message for the server's host; None if the settings do not describe it."""
    if not (config.host_name or config.host_contact or config.host_rules):
        return None
    return pb.Host(name=config.host_name, contact=config.host_contact, rules=config.host_rules)


def time_message(time: datetime | None) -> str:
    """Return a time in the format of messages, RFC 3339; empty for None."""
    return time.isoformat(timespec="seconds") if time is not None else ""


def split_message(split: Split, closing: ClosingTimes = NEVER_CLOSES) -> pb.Split:
    """Return the message for a split, as in ServerInfo."""
    return pb.Split(
        name=split.name,
        hidden=split.hidden,
        episodes=split.languages,
        sensors=split.sensors,
        data_hash=split.data_hash,
        closes_at=time_message(closing.of(split.name)),
        frozen=closing.is_frozen(split.name),
        texts={
            language: pb.Texts(alphabet=texts.alphabet, longest=texts.longest, longest_utf8=texts.longest_utf8)
            for language, texts in split.texts.items()
        },
    )


def account_message(caller: Caller, standings: Mapping[str, tuple[Quota, Usage]]) -> pb.Account:
    """Return the message for the authenticated caller, with its quota and usage on each split."""
    quotas = [pb.Quota(split=split, **asdict(quota), **asdict(use)) for split, (quota, use) in standings.items()]
    role = pb.Role.Value(f"ROLE_{caller.role.name}")
    return pb.Account(participant=caller.account or "", role=role, quotas=quotas)


def report_message(report: Report) -> pb.Report:
    """Return the message for the scores of a run."""
    return pb.Report(
        run=run_message(report.run, report.progress),
        signature=report.signature,
        rows=[row_message(name, intervals) for name, intervals in report.table.rows.items()],
        episodes=[_episode_scores(ending) for ending in report.endings],
    )


def breakdown_message(report: Report, breakdown: Breakdown) -> pb.Breakdown:
    """Return the message for the scores of a run by groups of turns."""
    run = run_message(report.run, report.progress)
    run.ClearField("bank_seconds_left")
    groups = [
        pb.TurnGroup(
            aspect=line.group.aspect,
            name=line.group.name,
            low=line.group.low,
            high=None if line.group.name else line.group.high,
            turns=line.found.turns,
            episodes=line.found.episodes,
            scores=[score_message(metric, interval) for metric, interval in line.found.scores.items()],
        )
        for line in breakdown.lines
    ]
    return pb.Breakdown(
        run=run,
        signature=report.signature,
        groups=groups,
        withheld=breakdown.withheld,
        rounded=breakdown.rounded,
        reads=breakdown.knows_demands,
    )


def receipt_message(receipt: SignedReceipt) -> pb.Receipt:
    """Return the message for a signed receipt."""
    return pb.Receipt(payload=receipt.payload, signature=receipt.signature, public_key=receipt.public_key)


def pose_message(pose: Pose) -> types_pb2.Pose:
    """Return the message for a pose."""
    return types_pb2.Pose(x=pose.x, z=pose.z, heading=pose.heading)


def cell_message(cell: RoomPosition) -> types_pb2.Cell:
    """Return the message for a cell of the assembly room."""
    return types_pb2.Cell(column=cell.column, level=cell.level, row=cell.row)


def oracle_message(episode: Episode, scene: Scene) -> pb.Oracle:
    """Return the message for the sensor "oracle": the ground truth and the scene's obstacles."""
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
    """Return the message for a row of a score table."""
    return pb.Row(name=name, scores=[score_message(metric, interval) for metric, interval in intervals.items()])


def score_message(metric: str, interval: Interval) -> pb.Score:
    """Return the message for a score, or a difference of two, with its interval."""
    score = pb.Score(metric=metric, mean=interval.mean, low=interval.low, high=interval.high)
    if interval.sections is not None:
        sections = interval.sections
        score.sections.CopyFrom(pb.Sections(deviation=sections.deviation, low=sections.low, high=sections.high))
    return score


def _episode_scores(ending: EpisodeEnding) -> pb.EpisodeScores:
    turns = [
        row_message(f"turn {number}", {metric: Interval(value, value, value) for metric, value in scores.items()})
        for number, scores in enumerate(ending.scores, start=1)
    ]
    cause = types_pb2.Cause.Value(f"CAUSE_{ending.cause}")
    return pb.EpisodeScores(episode_id=ending.episode_id, cause=cause, turns=turns, steps=ending.steps)
