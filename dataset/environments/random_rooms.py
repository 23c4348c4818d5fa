"""Random assembly tasks without end, each generated when it is played, without a city or a data folder."""

from functools import cache, lru_cache
from pathlib import Path

import arramon_lang as lang
from arramon_client.environments.backend import PlayerSettings, SplitInfo, TextBounds
from arramon_client.errors import UsageError
from arramon_client.world import SENSORS, STEPS_PER_PHASE
from arramon_dataset.environments.playable_split import DRAWN, PlayableSplit, playable_split
from arramon_dataset.generation.room_tasks import PREFIX, ROOM_SECTION, draw_task
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.instruction_texts import instructions_in
from arramon_server.episodes.splits import ROOMS_SPLIT, Split

SURVEYED = 24
"""Number of sample tasks that determine the maximum length of instructions."""


@lru_cache(2)
def playable_rooms(camera: str) -> PlayableSplit:
    """Return the split of generated tasks and its worlds. The split lists no episodes, as they are endless."""
    sections = {ROOM_SECTION.id: ROOM_SECTION}
    split = Split(DRAWN, hidden=False, source="drawn", episodes={}, sections=sections, data_hash="", training=True)
    return playable_split(split, camera)


def room_split(settings: PlayerSettings) -> SplitInfo:
    """Return the description of the generated tasks for environments.

    Raises:
        UsageError: if there is no such language.
    """
    if settings.language not in lang.available():
        there = ", ".join(lang.available())
        raise UsageError(f"there is no language {settings.language!r}; there are {there}")
    return SplitInfo(
        name=DRAWN,
        hidden=False,
        sensors=tuple(name for name in SENSORS if name != "oracle"),
        steps_per_phase=settings.steps_per_phase or STEPS_PER_PHASE,
        data_hash="",
        texts={settings.language: _texts(settings.language)},
    )


def draw_room(seed: int, language: str, episode_id: str | None = None) -> Episode:
    """Return the task of a seed, with instructions in one language.

    The task is the same in every language that can express it.

    Args:
        seed: of all random choices.
        language: of the instructions.
        episode_id: "room-" and a seed that replaces `seed`.

    Raises:
        UsageError: if the id is not of that form.
    """
    if episode_id is not None:
        number = episode_id.removeprefix(PREFIX)
        if not (episode_id.startswith(PREFIX) and number.isdecimal()):
            raise UsageError(
                f"there is no episode {episode_id!r}: the ids of drawn tasks are {PREFIX}0, {PREFIX}1, ..."
            )
        seed = int(number)
    texts = _texts(language)
    episode = _draw(seed, language, texts.longest, texts.longest_utf8)
    if episode is None:
        raise UsageError(f"no task could be drawn from the seed {seed}; use another")
    return episode


def _draw(seed: int, language: str, longest: int, longest_utf8: int) -> Episode | None:
    def fits(episode: Episode, _: object) -> bool:
        texts = instructions_in([episode], language)
        return all(len(text) <= longest and len(text.encode()) <= longest_utf8 for text in texts)

    drawn = draw_task(f"{PREFIX}{seed}", (ROOMS_SPLIT, seed), (language,), fits)
    return None if drawn is None else drawn.episode


@cache
def _texts(language: str) -> TextBounds:
    """Return the alphabet and the maximum lengths of a language's tasks: twice the longest of the sample tasks."""
    folder = Path(next(iter(lang.__path__))) / language
    written = "".join(path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.toml")))
    drawn = [_draw(seed, language, 1_000_000, 1_000_000) for seed in range(SURVEYED)]
    texts = instructions_in([episode for episode in drawn if episode is not None], language)
    alphabet = {character for character in written + "".join(texts) if character.isprintable()}
    return TextBounds(
        alphabet="".join(sorted(alphabet | {character.upper()[0] for character in alphabet})),
        longest=2 * max(map(len, texts)),
        longest_utf8=2 * max(len(text.encode()) for text in texts),
    )
