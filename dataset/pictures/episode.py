"""Picture files of one episode with its instructions, or of one section, for `arramon-server show`."""

from contextlib import closing
from pathlib import Path

from arramon_dataset.pictures.canvas import stack
from arramon_dataset.pictures.maps import prop_name, recovered_map, room_map, section_map
from arramon_dataset.pictures.views import contact_sheet
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.provenance import Provenance
from arramon_server.episodes.splits import check_split, read_splits, split_with_episode
from arramon_server.errors import NotFound, StorageError
from arramon_server.runs.play.worlds import Worlds
from arramon_server.sim.section import Section


def show(data: Path, episode_id: str, split: str | None, output: Path) -> list[Path]:
    """Write an episode's map, contact sheet and instructions. The sheet shows one language, the text file all.

    Args:
        data: the data folder.
        episode_id: for example "8900".
        split: name of the split; None for the first that contains the episode.
        output: folder for the files, created if missing.

    Returns:
        Paths of the files.

    Raises:
        NotFound: if the split or the episode does not exist.
        StorageError: if the files cannot be written.
    """
    chosen = split_with_episode(read_splits(data), episode_id, split)
    episode = chosen.episodes[episode_id]
    provenance = chosen.provenance.get(episode.section)
    street = section_map(chosen.sections[episode.section], episode, provenance=provenance)
    above = stack([street, room_map(episode)])
    with closing(Worlds({chosen.name: chosen})) as worlds:
        views = contact_sheet(episode, worlds.world(chosen.name, episode))
    paths = [output / f"{chosen.name}-{episode_id}-{name}" for name in ("map.png", "views.png", "instructions.txt")]
    try:
        output.mkdir(parents=True, exist_ok=True)
        above.save(paths[0])
        views.save(paths[1])
        paths[2].write_text(_texts(episode), encoding="utf-8")
    except OSError as error:
        raise StorageError(f"cannot write {error.filename}: {error.strerror}") from error
    return paths


def show_section(data: Path, section_id: str, split: str | None, output: Path) -> list[Path]:
    """Write a section's map, and a list of the things recovered from texts.

    Args:
        data: the data folder.
        section_id: for example "1".
        split: name of the split; None for the first that contains the section.
        output: folder for the files, created if missing.

    Returns:
        Paths of the files: the map, and the list if the section has a provenance.

    Raises:
        NotFound: if the split or the section does not exist.
        StorageError: if the files cannot be written.
    """
    splits = read_splits(data)
    check_split(splits, split)
    chosen = next((one for one in splits.values() if split in (None, one.name) and section_id in one.sections), None)
    if chosen is None:
        raise NotFound(f"there is no section {section_id!r} in {split or ', '.join(splits)}")
    section, provenance = chosen.sections[section_id], chosen.provenance.get(section_id)
    episodes = [one for one in chosen.episodes.values() if one.section == section_id]
    picture = recovered_map(section, provenance, episodes)
    paths = [output / f"{chosen.name}-section-{section_id}-map.png"]
    try:
        output.mkdir(parents=True, exist_ok=True)
        picture.save(paths[0])
        if provenance is not None:
            paths.append(output / f"{chosen.name}-section-{section_id}-recovered.txt")
            paths[1].write_text(_recovered(section, provenance), encoding="utf-8")
    except OSError as error:
        raise StorageError(f"cannot write {error.filename}: {error.strerror}") from error
    return paths


def _recovered(section: Section, provenance: Provenance) -> str:
    """Return a line for each recovered thing, most votes first."""
    listed = []
    for each in provenance.props:
        prop = section.props[each.index]
        listed.append((-each.votes, prop_name(prop), prop.x, prop.z))
    for each in provenance.buildings:
        building = section.buildings[each.index]
        listed.append((-each.votes, f"{building.facade} building", building.x, building.z))
    return "".join(f"{-votes:6.1f} votes  {name:24} at ({x:.1f}, {z:.1f})\n" for votes, name, x, z in sorted(listed))


def _texts(episode: Episode) -> str:
    """Return all instructions, one language after another."""
    return "".join(
        f"{language}, turn {number}, {phase}: {getattr(turn, phase)}\n"
        for language, turns in episode.instructions.items()
        for number, turn in enumerate(turns, start=1)
        for phase in ("navigation", "assembly")
    )
