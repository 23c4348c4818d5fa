"""People's texts of an imported split: halves for training and testing, and meanings parsed by the grammars."""

from collections.abc import Sequence
from pathlib import Path

import arramon_lang as lang
from arramon_agents.reading.reader.slots import rows_of
from arramon_agents.simulated.meanings import TextSample
from arramon_agents.simulated.training_split import read_training_split
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split


def halves(split: Split, language: str) -> tuple[list[Episode], list[Episode]]:
    """Split episodes into halves: every second one in playing order for training, and the others for testing."""
    episodes = split.in_playing_order(language)
    return episodes[1::2], episodes[::2]


def parse_people_texts(episodes: Sequence[Episode], language: str) -> list[TextSample]:
    """Parse the texts of episodes; return those that the grammar can parse and that rows can express."""
    speech = lang.load(language)
    samples = []
    for episode in episodes:
        for turn in episode.instructions[language]:
            for phase, text in (("navigation", turn.navigation), ("assembly", turn.assembly)):
                try:
                    sample = TextSample(text, language, speech.read(text, phase))
                    rows_of(sample.meaning)
                except (lang.CannotRead, ValueError):
                    continue
                samples.append(sample)
    return samples


def parse_training_half(data: Path, split: str, language: str) -> list[TextSample]:
    """Parse the texts of the training half of a split by the grammar.

    Raises:
        UsageError: if there is no such split, or a file of it is invalid.
    """
    return parse_people_texts(halves(read_training_split(data, split), language)[0], language)
