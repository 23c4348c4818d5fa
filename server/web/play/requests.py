"""Messages of the play page: JSON objects, checked field by field."""

import re
from dataclasses import dataclass
from typing import Any, TypeVar

from arramon.strict_json import NotJsonError, read_json
from arramon_client.world import TURN_DEGREES
from arramon_server.errors import BadInput, quoted

MAX_REQUEST_BYTES = 8192
"""Size limit of a message. The longest is the first one of a person who has played many runs."""

MAX_EARLIER_RUNS = 100
"""Maximum number of earlier runs that a first message names."""

MAX_EPISODES = 100
"""Maximum number of episodes of a new run on an open split."""

MAX_STEP = 1_000_000
"""Limit of step numbers: no episode has as many."""

_PLAYER = re.compile(r"[0-9a-f]{16,64}")
_RUN = re.compile(r"[0-9a-f]{32}")

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class NewRun:
    """A run to create.

    Attributes:
        split, language: what to play.
        episodes: number of episodes on an open split; a hidden one is played whole.
        participant: name of a person without a token; empty for none.
        earlier: ids of runs that the person played before, whose episodes come last.
    """

    split: str
    language: str
    episodes: int
    participant: str
    earlier: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Hello:
    """The first message of a page.

    Attributes:
        player: the browser's own name, which it keeps.
        token: token of the person's account; empty for none.
        size: side length of the images, in pixels.
        run: id of the run to continue, or a run to create.
        practice: whether the run is one of the tutorial.
        pauses: whether the page asks for each further episode with `next`, once the person has read how the last went.
    """

    player: str
    token: str
    size: int
    run: str | NewRun
    practice: bool = False
    pauses: bool = False


@dataclass(frozen=True, slots=True)
class Key:
    """An action for a step of an episode."""

    episode: str
    step: int
    action: int


@dataclass(frozen=True, slots=True)
class Look:
    """The person looks around in a step: the view in another heading, `degrees` clockwise of their own."""

    episode: str
    step: int
    degrees: int


@dataclass(frozen=True, slots=True)
class GiveUp:
    """The person gives up an episode."""

    episode: str


@dataclass(frozen=True, slots=True)
class Next:
    """The person goes on to the next episode."""


@dataclass(frozen=True, slots=True)
class AskScores:
    """The person asks for the scores of an ended episode, or of the ended run if `episode` is empty."""

    episode: str


@dataclass(frozen=True, slots=True)
class Publish:
    """The person puts the ended run on the leaderboard."""


def read_hello(text: str) -> Hello:
    """Parse the first message of a page.

    Raises:
        BadInput: if it is malformed.
    """
    fields = _fields(text)
    if fields.get("type") != "hello":
        raise BadInput(f"the first message is of type {quoted(str(fields.get('type')))}, expected 'hello'")
    player = _text(fields, "player", 64)
    if not _PLAYER.fullmatch(player):
        raise BadInput(f"player is {player!r}, expected 16 to 64 hexadecimal digits")
    run = _text(fields, "run", 32) if "run" in fields else ""
    if bool(run) == ("new" in fields):
        raise BadInput("the first message has `run` and `new`, or neither; expected one of them")
    if run and not _RUN.fullmatch(run):
        raise BadInput(f"run is {run!r}, expected 32 hexadecimal digits")
    practice, pauses = _flag(fields, "practice"), _flag(fields, "pauses")
    token, size = _text(fields, "token", 500, ""), _whole(fields, "size", 4096)
    return Hello(player, token, size, run or _new_run(fields), practice, pauses)


def read_request(text: str) -> Key | Look | GiveUp | Next | AskScores | Publish:
    """Parse a further message of a page.

    Raises:
        BadInput: if it is malformed.
    """
    fields = _fields(text)
    match fields.get("type"):
        case "key":
            return Key(_text(fields, "episode", 200), _whole(fields, "step", MAX_STEP), _whole(fields, "action", 3))
        case "look":
            return _look(fields)
        case "give_up":
            return GiveUp(_text(fields, "episode", 200))
        case "next":
            return Next()
        case "scores":
            return AskScores(_text(fields, "episode", 200, ""))
        case "publish":
            return Publish()
        case other:
            raise BadInput(
                f"a message is of type {quoted(str(other))}, "
                "expected 'key', 'look', 'give_up', 'next', 'scores' or 'publish'"
            )


def _look(fields: dict[str, Any]) -> Look:
    degrees = _whole(fields, "degrees", 359)
    if degrees % TURN_DEGREES:
        raise BadInput(f"degrees is {degrees}, expected a multiple of {TURN_DEGREES}")
    return Look(_text(fields, "episode", 200), _whole(fields, "step", MAX_STEP), degrees)


def _new_run(fields: dict[str, Any]) -> NewRun:
    new = fields["new"]
    if not isinstance(new, dict):
        raise BadInput("new is no object, expected one with split and language")
    earlier = new.get("earlier", [])
    if not isinstance(earlier, list) or len(earlier) > MAX_EARLIER_RUNS:
        raise BadInput(f"earlier is no list of at most {MAX_EARLIER_RUNS} ids of runs")
    if not all(isinstance(one, str) and _RUN.fullmatch(one) for one in earlier):
        raise BadInput("earlier has something that is no id of a run, expected 32 hexadecimal digits")
    return NewRun(
        _text(new, "split", 100),
        _text(new, "language", 20),
        _whole(new, "episodes", MAX_EPISODES),
        _text(new, "participant", 100, ""),
        tuple(earlier),
    )


def _fields(text: str) -> dict[str, Any]:
    if len(text) > MAX_REQUEST_BYTES:
        raise BadInput(f"a message has {len(text)} characters; at most {MAX_REQUEST_BYTES} are allowed")
    try:
        content = read_json(text, deepest=4)
    except NotJsonError as error:
        raise BadInput(f"a message {error}; expected a JSON object") from error
    if not isinstance(content, dict):
        raise BadInput("a message is no JSON object")
    return content


def _flag(fields: dict[str, Any], name: str) -> bool:
    value = fields.get(name, False)
    if not isinstance(value, bool):
        raise BadInput(f"{name} is neither true nor false")
    return value


def _text(fields: dict[str, Any], name: str, longest: int, default: str | None = None) -> str:
    value = fields.get(name, default)
    if not isinstance(value, str):
        raise BadInput(f"{name} is {'missing' if name not in fields else 'no text'}, expected a text")
    if len(value) > longest:
        raise BadInput(f"{name} has {len(value)} characters; at most {longest} are allowed")
    return value


def _whole(fields: dict[str, Any], name: str, most: int) -> int:
    value = fields.get(name)
    if type(value) is not int or not 0 <= value <= most:
        shown = "missing" if name not in fields else quoted(str(value))
        raise BadInput(f"{name} is {shown}, expected a whole number from 0 to {most}")
    return value
