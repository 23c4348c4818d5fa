"""What came of each object of an episode, for the person who played it: what was picked up, and where it was placed."""

from dataclasses import dataclass
from enum import StrEnum

from arramon_server.scoring.episode_scores import Scores
from arramon_server.scoring.metrics import rpod
from arramon_server.sim.catalogue import ObjectType
from arramon_server.web.episodes_page import NOTHING, failure_of


class Picked(StrEnum):
    """What a turn's navigation ended with. The values are keys of texts."""

    RIGHT = "picked_right"
    TOO_FAR = "picked_too_far"
    """The target, taken from so far away that the path does not count (CTC-3)."""
    LOOK_ALIKE = "picked_look_alike"
    """An object of the target's type, but not the target."""
    OTHER = "picked_other"
    LIMIT_RIGHT = "limit_right"
    """A limit took the target."""
    LIMIT_TOO_FAR = "limit_too_far"
    """A limit took the target, from so far away that the path does not count."""
    LIMIT_OTHER = "limit_other"
    NOTHING = "picked_nothing"


class Put(StrEnum):
    """What a turn's assembly ended with. The values are keys of texts."""

    RIGHT = "put_right"
    ONE_OFF = "put_one_off"
    """In a cell beside, above or below the right one."""
    ELSEWHERE = "put_elsewhere"
    NOTHING = "put_nothing"
    """Nothing was placed, or a limit placed it."""
    GIVEN_UP = "put_given_up"
    """The person gave the episode up before placing it."""


@dataclass(frozen=True, slots=True)
class TurnVerdict:
    """What came of one object.

    Attributes:
        picked: what was picked up.
        put: where it was placed.
        is_right: whether path, object and cell all count.
    """

    picked: Picked
    put: Put
    is_right: bool


def turn_verdict(
    scores: Scores, target: ObjectType, carried: ObjectType | None, *, forced: bool, gave_up: bool = False
) -> TurnVerdict:
    """Return what came of a turn.

    Args:
        scores: scores of the turn.
        target: type of its target.
        carried: type of the object that was carried into the room; None for none.
        forced: whether a limit picked it up.
        gave_up: whether the person gave the episode up, and no limit placed the object before.
    """
    picked, put = _picked(scores, target, carried, forced=forced), _put(scores, gave_up=gave_up)
    return TurnVerdict(picked, put, failure_of(scores) == NOTHING)


def _picked(scores: Scores, target: ObjectType, carried: ObjectType | None, *, forced: bool) -> Picked:
    if carried is None:
        return Picked.NOTHING
    if scores["CTC-0"] and scores["CTC-3"]:
        return Picked.LIMIT_RIGHT if forced else Picked.RIGHT
    if scores["CTC-0"]:
        return Picked.LIMIT_TOO_FAR if forced else Picked.TOO_FAR
    if forced:
        return Picked.LIMIT_OTHER
    return Picked.LOOK_ALIKE if carried == target else Picked.OTHER


def _put(scores: Scores, *, gave_up: bool) -> Put:
    if scores["PTC"]:
        return Put.RIGHT
    if not scores["rPOD"]:
        return Put.GIVEN_UP if gave_up else Put.NOTHING
    return Put.ONE_OFF if scores["rPOD"] == rpod(1) else Put.ELSEWHERE
