"""`arramon-server show`: writes the pictures of one episode, and its instructions in every language."""

from contextlib import closing
from pathlib import Path

from server.episodes.episode import Episode
from server.episodes.splits import Split, read_splits
from server.errors import NotFound, StorageError
from server.runs.worlds import Worlds
from server.show.canvas import stacked
from server.show.maps import room_map, section_map
from server.show.views import contact_sheet


def show(data: Path, episode_id: str, split: str | None, output: Path) -> list[Path]:
    """Writes an episode's map, contact sheet and instructions: the sheet has those of one language only.

    Args:
        data: the data folder.
        episode_id: such as "8900".
        split: by name; None for the first that has the episode.
        output: folder for the files; made where it is not there.

    Returns:
        The files' paths.

    Raises:
        NotFound: if there is no such split or episode.
        StorageError: if the files cannot be written.
    """
    chosen = _find(read_splits(data), episode_id, split)
    episode = chosen.episodes[episode_id]
    above = stacked([section_map(chosen.sections[episode.section], episode), room_map(episode)])
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
    """All instructions, language after language."""
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
