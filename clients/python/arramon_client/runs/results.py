"""Results of a run as plain data."""

from dataclasses import replace
from typing import Any

from arramon.v1 import evaluation_pb2
from arramon_client import results
from arramon_client.errors import ProtocolError
from arramon_client.runs.info import RunInfo, info_of
from arramon_client.runs.live import LiveRun

TURNS = ("turn 1", "turn 2")


def info_now(live: LiveRun) -> RunInfo:
    """Return the description of a run as of the latest message, with the number of ended episodes."""
    found = info_of(live.run)
    return replace(found, ended=max(found.ended, live.episodes_ended))


def report_data(report: evaluation_pb2.Report) -> dict[str, Any]:
    """Return a report as plain data: the content of the results file, without failures of an agent."""
    content = results.results(report, ())
    del content["agent_failures"]
    return content


def scores_of(report: evaluation_pb2.Report, episode_id: str) -> dict[str, dict[str, float]] | None:
    """Return an episode's scores by row ("turn 1", "turn 2", their mean "total") and metric; None if not disclosed.

    Raises:
        ProtocolError: if the report does not have the same scores for two turns.
    """
    for episode in report.episodes:
        if episode.episode_id == episode_id:
            turns = {row.name: {score.metric: score.mean for score in row.scores} for row in episode.turns}
            first, second = turns.get(TURNS[0], {}), turns.get(TURNS[1], {})
            if turns.keys() != set(TURNS) or first.keys() != second.keys():
                raise ProtocolError(f"the scores of episode {episode_id} are not those of two turns")
            return {**turns, "total": {name: (first[name] + second[name]) / 2 for name in first}}
    return None
