"""Reader of demonstrations in the plain format of `arramon-server export-demos`; frames are rendered on demand.

demonstrations = Demonstrations(Path("demonstrations/train-plain"))
for demonstration in demonstrations:
    for observation, action in demonstrations.draw(demonstration, "hi", sensors=("rgb",), image_size=128):
        ...
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from arramon.strict_json import NotJsonError, read_json
from arramon_client.agent import Observation
from arramon_client.errors import UsageError

RECORD, FORMAT, VERSION = "demonstrations.json", "arramon-demonstrations", 1

FILES = "demonstrations-*.jsonl"

KINDS = {
    **dict.fromkeys(("episode_id", "section", "cause"), str),
    **dict.fromkeys(("instructions", "scores"), dict),
    **dict.fromkeys(("actions", "turns", "phases", "poses"), list),
    "finished": bool,
}
"""Type of each field of a demonstration."""

"""Names of the phases, by number."""


@dataclass(frozen=True, eq=False)
class Demonstration:
    """The recorded actions of one episode, with poses, instructions and scores.

    Attributes:
        episode_id: id of the episode.
        section: section of the city.
        instructions: for each language and turn, the instructions for navigation and assembly.
        actions: (steps,) uint8, numbered as in `agent.Action`.
        turns: (steps,) uint8, the turn before each action, 1 or 2.
        phases: (steps,) uint8, the phase before each action, as an index into `PHASES`.
        poses: (steps, 3) float64, (x, z, heading) before each action, in units and degrees; in the room x and z are
            column and row.
        cause: cause of the episode's end, for example "AGENT_FINISHED".
        finished: whether the actions reach the end of the episode.
        scores: scores by row ("turn 1", "turn 2") and metric.
    """

    episode_id: str
    section: str
    instructions: Mapping[str, Sequence[Sequence[str]]]
    actions: npt.NDArray[np.uint8]
    turns: npt.NDArray[np.uint8]
    phases: npt.NDArray[np.uint8]
    poses: npt.NDArray[np.float64]
    cause: str
    finished: bool
    scores: Mapping[str, Mapping[str, float]]

    def __len__(self) -> int:
        """Return the number of steps."""
        return len(self.actions)

    def instruction(self, language: str, step: int) -> str:
        """Return the instruction at a step.

        Raises:
            UsageError: if the episode has no instructions in the language.
        """
        if language not in self.instructions:
            there = ", ".join(self.instructions)
            raise UsageError(f"episode {self.episode_id!r} has no instructions in {language!r}; it has {there}")
        text: str = self.instructions[language][self.turns[step] - 1][self.phases[step]]
        return text


class Demonstrations(Sequence[Demonstration]):
    """All demonstrations of a folder, kept in memory at a few kilobytes each.

    Args:
        folder: folder written by `arramon-server export-demos --format plain`.

    Attributes:
        settings: settings of the export, for example "split", "languages", "data_hash" and "steps_per_phase".

    Raises:
        UsageError: if the folder holds no complete export in the plain format.
    """

    def __init__(self, folder: Path) -> None:
        self.settings = _settings(folder)
        self._all = [one for path in sorted(folder.glob(FILES)) for one in _demonstrations(path)]
        expected = sum(self.settings["episodes_by_language"].values())
        if sum(len(one.instructions) for one in self._all) != expected:
            raise UsageError(f"files are missing in {folder}: expected {expected} episodes, each language counted")

    def __len__(self) -> int:
        """Return the number of episodes."""
        return len(self._all)

    @overload
    def __getitem__(self, index: int) -> Demonstration: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Demonstration]: ...
    def __getitem__(self, index: int | slice) -> Demonstration | Sequence[Demonstration]:
        """Return one demonstration, or a slice of them."""
        return self._all[index]

    def draw(
        self,
        demonstration: Demonstration,
        language: str,
        *,
        sensors: Sequence[str] = ("rgb", "depth"),
        image_size: int = 224,
        data: Path | None = None,
    ) -> Iterator[tuple[Observation, int]]:
        """Yield the observation before each action, rendered again, and the action. Requires the server package.

        Args:
            demonstration: a demonstration of this folder.
            language: language of the instructions.
            sensors: sensors of the observations.
            image_size: side length of images, in pixels.
            data: the data folder; None for $ARRAMON_DATA or ./arramon-data.

        Raises:
            BadArgument: if an argument is wrong.
            UsageError: if the split in the data folder is not the one that was exported.
        """
        from arramon_client.environments.options import make_options
        from arramon_client.environments.players import open_players

        options = make_options(
            lang=language,
            split=self.settings["split"],
            sensors=tuple(sensors),
            image_size=image_size,
            data=data,
            steps_per_phase=self.settings["steps_per_phase"],
        )
        player = open_players(options).player
        if player.split.data_hash != self.settings["data_hash"]:
            raise UsageError(
                f"the split {player.split.name!r} here has the data {player.split.data_hash[:12]}, expected "
                f"{self.settings['data_hash'][:12]}, from which the demonstrations were exported"
            )
        seen: Observation | None = player.begin(demonstration.episode_id, 0)
        for action in demonstration.actions.tolist():
            assert seen is not None
            yield seen, action
            seen = player.step(action).observation


def _settings(folder: Path) -> dict[str, Any]:
    path = folder / RECORD
    try:
        record = read_json(path.read_bytes())
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error}; expected a folder that `export-demos` wrote") from error
    except NotJsonError as error:
        raise UsageError(f"{path} {error}; expected a folder that `export-demos` wrote") from error
    if not isinstance(record, dict) or (record.get("format"), record.get("version")) != (FORMAT, VERSION):
        raise UsageError(f"{path} is not of the format {FORMAT!r}, version {VERSION}")
    settings, counts = record.get("settings"), record.get("episodes_by_language")
    if not (isinstance(settings, dict) and isinstance(counts, dict) and all(type(n) is int for n in counts.values())):
        raise UsageError(f"{path} has no settings, or no numbers of episodes by language")
    if settings.get("format") != "plain":
        raise UsageError(f"{folder} is in the format {settings.get('format')!r}, expected 'plain'")
    if not record.get("complete"):
        raise UsageError(f"the export to {folder} is not complete; give the same `export-demos` command again")
    return {**settings, "episodes_by_language": counts}


def _demonstrations(path: Path) -> Iterator[Demonstration]:
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            try:
                yield _demonstration(read_json(line))
            except NotJsonError as error:
                raise UsageError(f"{path}:{number}: it {error}") from error
            except _ShapeError as error:
                raise UsageError(f"{path}:{number}: {error}") from error


class _ShapeError(Exception):
    """A demonstration lacks a field, or a field has the wrong type or value; the message names it."""


def _demonstration(line: Any) -> Demonstration:
    if not isinstance(line, dict):
        raise _ShapeError("it is not an object")
    for name, kind in KINDS.items():
        if not isinstance(line.get(name), kind):
            raise _ShapeError(f"its {name} is {line.get(name)!r:.60}, expected a {kind.__name__}")
    steps = len(line["actions"])
    numbers = {name: _array(line, name, np.uint8, (steps,)) for name in ("actions", "turns", "phases")}
    for name, fewest, most in (("actions", 0, 3), ("turns", 1, 2), ("phases", 0, 1)):
        if steps and not fewest <= numbers[name].min() <= numbers[name].max() <= most:
            raise _ShapeError(f"its {name} are not all from {fewest} to {most}")
    for language, turns in line["instructions"].items():
        phases = [text for turn in turns for text in turn] if _is_pair(turns) and all(map(_is_pair, turns)) else []
        if len(phases) != 4 or not all(isinstance(text, str) for text in phases):
            raise _ShapeError(f"its instructions in {language!r} are not two texts for each of two turns")
    return Demonstration(
        episode_id=line["episode_id"],
        section=line["section"],
        instructions=line["instructions"],
        poses=_array(line, "poses", np.float64, (steps, 3)),
        cause=line["cause"],
        finished=line["finished"],
        scores=line["scores"],
        **numbers,
    )


def _array(line: Mapping[str, Any], name: str, kind: type[Any], shape: tuple[int, ...]) -> npt.NDArray[Any]:
    try:
        array = np.asarray(line[name], kind).reshape(shape)
    except (OverflowError, TypeError, ValueError) as error:
        raise _ShapeError(f"its {name} are not numbers, {' x '.join(map(str, shape))}: {error}") from error
    return array


def _is_pair(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 2
