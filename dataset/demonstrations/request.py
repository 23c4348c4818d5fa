"""Requests for an export, and their validation."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from arramon_client.world import DEFAULT_SENSORS, SENSORS
from arramon_server import __version__
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput, Forbidden

PLAIN, MINARI, LEROBOT, HUGGINGFACE = "plain", "minari", "lerobot", "huggingface"

FORMATS = (MINARI, LEROBOT, HUGGINGFACE, PLAIN)
"""Names of the formats; all but the last contain frames."""

EXPORTED_SENSORS = SENSORS[:4]
"""Sensors that can be exported: those of agents, without the ground truth."""

DEFAULT_SIZE = 224

SMALLEST, LARGEST, STRIDE, FURTHER = 8, 448, 8, (84,)
"""Side lengths of images, in pixels, as in environments: multiples of STRIDE from SMALLEST to LARGEST, and FURTHER."""

REWARDS = ("sparse", "progress", "none")
"""Names of the rewards (`arramon_dataset.environments.rewards`)."""

EPISODES_PER_PART = 16
"""Episodes in one part. A resumed export starts with the first unfinished part."""


@dataclass(frozen=True, slots=True)
class ExportRequest:
    """The user's settings of an export.

    Attributes:
        data: the data folder.
        split: name of the split.
        format: one of `FORMATS`.
        languages: of the instructions, sorted; empty for all languages of the split.
        sensors: some of `EXPORTED_SENSORS`, in their order; empty in the format "plain".
        size: side length of the images, in pixels; 0 in the format "plain".
        reward: one of `REWARDS`.
        run_id: the recorded run to export; None for the ground truth.
        episodes: number of episodes to export, the first in the split's playing order; None for all.
        part_size: episodes in one part.
        single_dataset: whether Minari has one dataset for all languages; otherwise one for each.
    """

    data: Path
    split: str
    format: str
    languages: tuple[str, ...] = ()
    sensors: tuple[str, ...] = DEFAULT_SENSORS
    size: int = DEFAULT_SIZE
    reward: str = "sparse"
    run_id: str | None = None
    episodes: int | None = None
    part_size: int = EPISODES_PER_PART
    single_dataset: bool = False


@dataclass(frozen=True, slots=True)
class ResolvedExport:
    """A validated export request, with the counts and properties of its split filled in.

    Attributes:
        request: with languages and sensors filled in.
        data_hash: of the split.
        source: origin of the split's episodes, as free text.
        camera: name of the camera that renders the frames.
        steps_per_phase: the step limit of a phase.
        parts: number of parts.
        episodes, steps: numbers of demonstrations and of their steps; each language counts separately.
    """

    request: ExportRequest
    data_hash: str
    source: str
    camera: str
    steps_per_phase: int
    parts: int
    episodes: int
    steps: int

    def settings(self) -> dict[str, Any]:
        """Return everything that the exported files depend on, as plain data."""
        request = {name: value for name, value in asdict(self.request).items() if name != "data"}
        if not self.request.single_dataset:  # Records of earlier releases lack this setting.
            del request["single_dataset"]
        counts = {name: getattr(self, name) for name in ("data_hash", "source", "camera", "steps_per_phase")}
        more = {
            "server_version": __version__,
            "parts": self.parts,
            "total_episodes": self.episodes,
            "total_steps": self.steps,
        }
        return {**{name: list(v) if isinstance(v, tuple) else v for name, v in request.items()}, **counts, **more}


def make_request(
    data: Path,
    split: str,
    format_: str,
    *,
    languages: Sequence[str] = (),
    sensors: Sequence[str] | None = None,
    size: int | None = None,
    reward: str = "sparse",
    run_id: str | None = None,
    episodes: int | None = None,
    part_size: int = EPISODES_PER_PART,
    single_dataset: bool = False,
) -> ExportRequest:
    """Return a valid request; `check_request` checks it against the split.

    Raises:
        BadInput: if a setting is invalid; the message says what was expected.
    """
    if format_ not in FORMATS:
        raise BadInput(f"there is no format {format_!r}; there are {', '.join(FORMATS)}")
    if format_ == PLAIN and (sensors is not None or size is not None):
        raise BadInput(
            f"the format {PLAIN!r} holds no frames, so it takes neither sensors nor a size: leave them out, or choose "
            f"one of {', '.join(FORMATS[:-1])}"
        )
    if single_dataset and format_ != MINARI:
        raise BadInput(f"--single-dataset applies to the format {MINARI!r} only; {format_!r} has one dataset anyway")
    if reward not in REWARDS:
        raise BadInput(f"there is no reward {reward!r}; there are {', '.join(REWARDS)}")
    if episodes is not None and episodes < 1:
        raise BadInput(f"the number of episodes is {episodes}; expected at least 1")
    if part_size < 1:
        raise BadInput(f"the number of episodes in a part is {part_size}; expected at least 1")
    sensors, size = ((), 0) if format_ == PLAIN else (_sensors(sensors), _size(size))
    return ExportRequest(
        data,
        split,
        format_,
        tuple(sorted(set(languages))),
        sensors,
        size,
        reward,
        run_id,
        episodes,
        part_size,
        single_dataset,
    )


def check_request(request: ExportRequest, split: Split) -> None:
    """Check a request against its split.

    Raises:
        Forbidden: if the split is hidden.
        BadInput: if the split lacks a language or a sensor.
    """
    if split.hidden:
        raise Forbidden(
            f"the split {split.name!r} is hidden: its ground truth never leaves the server, nor do runs on it; "
            "demonstrations can be exported from open splits only"
        )
    for language in request.languages:
        if language not in split.languages:
            raise BadInput(
                f"the split {split.name!r} has no language {language!r}; it has {', '.join(split.languages)}"
            )
    for sensor in request.sensors:
        if sensor not in split.sensors:
            raise BadInput(f"the split {split.name!r} has no sensor {sensor!r}; it has {', '.join(split.sensors)}")


def _sensors(given: Sequence[str] | None) -> tuple[str, ...]:
    chosen = DEFAULT_SENSORS if given is None else given
    for sensor in chosen:
        if sensor not in EXPORTED_SENSORS:
            raise BadInput(f"there is no sensor {sensor!r} to export; there are {', '.join(EXPORTED_SENSORS)}")
    if not chosen:
        raise BadInput(f"no sensor was named; there are {', '.join(EXPORTED_SENSORS)}")
    return tuple(sensor for sensor in EXPORTED_SENSORS if sensor in chosen)


def _size(given: int | None) -> int:
    size = DEFAULT_SIZE if given is None else given
    if size not in FURTHER and (size % STRIDE or not SMALLEST <= size <= LARGEST):
        further = ", ".join(map(str, FURTHER))
        raise BadInput(
            f"the size is {size}; expected a multiple of {STRIDE} from {SMALLEST} to {LARGEST}, or {further}"
        )
    return size
