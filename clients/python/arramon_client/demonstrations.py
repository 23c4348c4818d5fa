"""Demonstrations in the plain format of `arramon-server export-demos`: actions, poses and texts; frames on demand.

demonstrations = Demonstrations(Path("demonstrations/train-plain"))
for demonstration in demonstrations:
    for observation, action in demonstrations.draw(demonstration, "hi", sensors=("rgb",), image_size=128):
        ...
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from arramon_client.agent import Observation
from arramon_client.errors import UsageError

RECORD, FORMAT, VERSION = "demonstrations.json", "arramon-demonstrations", 1

FILES = "demonstrations-*.jsonl"

PHASES = ("navigation", "assembly")
"""Names of the phases, by number."""


@dataclass(frozen=True, eq=False)
class Demonstration:
    """What was done in one episode.

    Attributes:
        episode_id: the episode.
        section: of the city.
        instructions: by language and turn, those of navigation and assembly.
        actions: (steps,) uint8, numbered as `agent.Action`.
        turns: (steps,) uint8, 1 or 2, before each action.
        phases: (steps,) uint8, index in `PHASES`, before each action.
        poses: (steps, 3) float64, (x, z, heading) before each action: units and degrees; in the room column and row.
        cause: why the episode ended, such as "AGENT_FINISHED".
        finished: whether the actions end the episode.
        scores: value by metric, for "turn 1" and "turn 2".
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
        """Return the instruction that holds at a step.

        Raises:
            UsageError: if there is none in the language.
        """
        if language not in self.instructions:
            there = ", ".join(self.instructions)
            raise UsageError(f"episode {self.episode_id!r} has no instructions in {language!r}; it has {there}")
        text: str = self.instructions[language][self.turns[step] - 1][self.phases[step]]
        return text


class Demonstrations(Sequence[Demonstration]):
    """The demonstrations of a folder, in memory: a few kilobytes each.

    Args:
        folder: that `arramon-server export-demos --format plain` wrote.

    Attributes:
        settings: of the export, such as "split", "languages", "data_hash" and "steps_per_phase".

    Raises:
        UsageError: if the folder holds no complete export in the plain format.
    """

    def __init__(self, folder: Path) -> None:
        self.settings = _settings(folder)
        self._all = [_demonstration(line) for path in sorted(folder.glob(FILES)) for line in _lines(path)]
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
        """Return one, or some."""
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
        """Yield what an agent saw before each action, and the action. It needs the environments, in this process.

        Args:
            demonstration: one of these.
            language: of the instructions.
            sensors: that the observations have.
            image_size: side length of images, in pixels.
            data: the data folder; None for $ARRAMON_DATA or ./arramon-data.

        Raises:
            BadArgument: if an argument is wrong.
            UsageError: if the split in the data folder is not the one that was exported.
        """
        from arramon_client.environments.options import make_options
        from arramon_client.environments.players import open_player

        options = make_options(
            lang=language,
            split=self.settings["split"],
            sensors=tuple(sensors),
            image_size=image_size,
            data=data,
            steps_per_phase=self.settings["steps_per_phase"],
        )
        player = open_player(options).player
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
        record = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise UsageError(f"{path} cannot be read: {error}; expected a folder that `export-demos` wrote") from error
    if not isinstance(record, dict) or (record.get("format"), record.get("version")) != (FORMAT, VERSION):
        raise UsageError(f"{path} is not of the format {FORMAT!r}, version {VERSION}")
    if record["settings"]["format"] != "plain":
        raise UsageError(f"{folder} is in the format {record['settings']['format']!r}, expected 'plain'")
    if not record["complete"]:
        raise UsageError(f"the export to {folder} is not complete; give the same `export-demos` command again")
    return {**record["settings"], "episodes_by_language": record["episodes_by_language"]}


def _lines(path: Path) -> Iterator[dict[str, Any]]:
    with path.open(encoding="utf-8") as file:
        for number, line in enumerate(file, start=1):
            try:
                yield json.loads(line)
            except ValueError as error:
                raise UsageError(f"{path}:{number}: is not JSON: {error}") from error


def _demonstration(line: Mapping[str, Any]) -> Demonstration:
    numbers = {name: np.asarray(line[name], np.uint8) for name in ("actions", "turns", "phases")}
    return Demonstration(
        episode_id=line["episode_id"],
        section=line["section"],
        instructions=line["instructions"],
        poses=np.asarray(line["poses"], np.float64).reshape(-1, 3),
        cause=line["cause"],
        finished=line["finished"],
        scores=line["scores"],
        **numbers,
    )
