"""The protocol of instruction writers, through which generation gets the texts of its drafts."""

from collections.abc import Mapping
from typing import Protocol

from arramon_dataset.generation.draft import Draft
from arramon_dataset.generation.site import GenerationSite
from arramon_server.episodes.episode import Instructions, Turn
from arramon_server.sim.geometry import Pose


class DraftWriter(Protocol):
    """Writes the instructions of drafts. All its random choices are seeded by names (see `randomness.seeded`)."""

    def can_describe(
        self, start: Pose, turn: Turn, number: int, site: GenerationSite, names: tuple[object, ...]
    ) -> bool:
        """Return whether the path of a turn can be described, as far as this is known before the episode is complete.

        Args:
            start: pose at the beginning of the turn.
            turn: the turn.
            number: 1 or 2.
            site: section of the episode.
            names: seed of the episode's instructions.
        """

    def __call__(
        self, draft: Draft, site: GenerationSite, names: tuple[object, ...]
    ) -> Mapping[str, tuple[Instructions, Instructions]] | None:
        """Return both turns' instructions by language, or None if the draft has to be replaced by another."""
