"""Pictures and instruction texts of one episode as files, for `arramon-server show`."""

from contextlib import closing
from pathlib import Path

from server.dataset.pictures.canvas import stack
from server.dataset.pictures.maps import room_map, section_map
from server.dataset.pictures.views import contact_sheet
from server.episodes.episode import Episode
from server.episodes.splits import Split, read_splits
from server.errors import NotFound, StorageError
from server.runs.play.worlds import Worlds


def show(data: Path, episode_id: str, split: str | None, output: Path) -> list[Path]:
    """Write an episode's map, contact sheet and instructions. The sheet shows one language, the text file all.

    Args:
        data: the data folder.
        episode_id: such as "8900".
        split: name of the split; None for the first that contains the episode.
        output: folder for the files, created if missing.

    Returns:
        Paths of the files.

    Raises:
        NotFound: if the split or the episode does not exist.
        StorageError: if the files cannot be written.
    """
    chosen = _find(read_splits(data), episode_id, split)
    episode = chosen.episodes[episode_id]
    above = stack([section_map(chosen.sections[episode.section], episode), room_map(episode)])
    with closing(Worlds({chosen.name: chosen})) as worlds:
        views = contact_sheet(episode, chosen.name, worlds)
    paths = [output / f"{chosen.name}-{episode_id}-{name}" for name in ("map.png", "views.png", "instructions.txt")]
    try:
        output.mkdir(parents=True, exist_ok=True)
        above.save(paths[0])
        views.save(paths[1])
        paths[2].write_text(_texts(episode), encoding="utf-8")
    except OSError as error:
        raise StorageError(f"cannot write {error.filename}: {error.strerror}") from error
    return paths


def _texts(episode: Episode) -> str:
    """Return all instructions, one language after another."""
    return "".join(
        f"{language}, turn {number}, {phase}: {getattr(turn, phase)}\n"
        for language, turns in episode.instructions.items()
        for number, turn in enumerate(turns, start=1)
        for phase in ("navigation", "assembly")
    )


def _find(splits: dict[str, Split], episode_id: str, name: str | None) -> Split:
    if name is not None and name not in splits:
        raise NotFound(f"there is no split {name!r}; there are {', '.join(splits)}")
    for split in splits.values():
        if name in (None, split.name) and episode_id in split.episodes:
            return split
    raise NotFound(f"there is no episode {episode_id!r} in {name or ', '.join(splits)}")
