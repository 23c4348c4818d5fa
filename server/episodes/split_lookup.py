"""The served splits by name, with further ones that are found only when they are asked for."""

from collections.abc import Iterator, Mapping

from arramon_server.episodes.splits import Split

SEPARATOR = "/"
"""Further splits have it in their names, which no split of the data folder has, as that is the name of a folder."""


class SplitLookup(Mapping[str, Split]):
    """Mapping of the host's splits, which falls back on others for names that have a `SEPARATOR`.

    Iteration and length include the host's splits only, so that no list or leaderboard shows the others.

    Args:
        own: the splits of the data folder, by name.
    """

    def __init__(self, own: Mapping[str, Split]) -> None:
        self._own = own
        self._others: list[Mapping[str, Split]] = []

    def add(self, others: Mapping[str, Split]) -> None:
        """Add splits to fall back on."""
        self._others.append(others)

    def __getitem__(self, name: str) -> Split:
        if name in self._own or SEPARATOR not in name:
            return self._own[name]
        for others in self._others:
            try:
                return others[name]
            except KeyError:
                continue
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._own)

    def __len__(self) -> int:
        return len(self._own)
