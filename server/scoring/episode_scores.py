"""Scores of the two turns of an episode, computed from its record."""

from collections.abc import Mapping
from dataclasses import dataclass

from arramon_server.scoring.metrics import ctc_within, ndtw, placement_distance, ptc, rpod
from arramon_server.scoring.trajectory import EpisodeRecord, TurnRecord

CTC_DISTANCES = {"CTC-3": 3.0, "CTC-5": 5.0, "CTC-7": 7.0}
"""Metric name -> distance k, in units."""

GATES = ("CTC-0", *CTC_DISTANCES)
"""Metrics that gate placement scores. The paper's tables use CTC-3."""

PLACEMENT = ("rPOD", "PTC")

METRICS = ("nDTW", *GATES, *PLACEMENT, *(f"{name}@{gate}" for gate in GATES for name in PLACEMENT))
"""All metrics in the order of the paper's tables: ungated first, then `rPOD@CTC-0`, `PTC@CTC-0`, `rPOD@CTC-3`, ..."""

Scores = Mapping[str, float]
"""Metric name -> value in [0, 1], with every name of METRICS, in their order."""


@dataclass(frozen=True, slots=True)
class EpisodeScores:
    """The scores of one episode.

    Attributes:
        episode_id: id of the episode, unique in the split.
        section: section of the city.
        turns: scores of turn 1 and turn 2.
    """

    episode_id: str
    section: str
    turns: tuple[Scores, Scores]


def score_episode(record: EpisodeRecord) -> EpisodeScores:
    """Return the scores of both turns of an episode; a turn that was not played scores zero.

    Raises:
        ValueError: if a reference path is empty.
    """
    first, second = record.turns
    return EpisodeScores(record.episode_id, record.section, (score_turn(first), score_turn(second)))


def score_turn(turn: TurnRecord) -> Scores:
    """Return the scores of one turn.

    A turn whose navigation phase did not end scores zero in all metrics, and one whose assembly phase did not end
    scores zero in rPOD and PTC. A forced placement gives rPOD = PTC = 0, also ungated. A forced pick-up does not change
    the scores by itself: the paper's appendix says that it gives 0, but the original code, which produced the paper's
    tables, leaves it to the gates. So CTC-0 depends on which object is carried, not on who picked it up.

    Raises:
        ValueError: if the reference path is empty.
    """
    values = dict.fromkeys(METRICS, 0.0)
    similarity = ndtw(
        turn.path, turn.reference_path
    )  # first, since a record without a reference is an error in any case
    if not turn.navigation_ended:
        return values
    values["nDTW"] = similarity
    values["CTC-0"] = float(turn.picked_target)
    for name, k in CTC_DISTANCES.items():
        values[name] = float(ctc_within(turn.final_position, turn.target_position, k))
    if turn.placed_cell is not None and not turn.placement_forced:
        distance = placement_distance(turn.placed_cell, turn.target_cell)
        values["rPOD"], values["PTC"] = rpod(distance), ptc(distance)
    for gate in GATES:
        for name in PLACEMENT:
            values[f"{name}@{gate}"] = values[name] * values[gate]
    return values
