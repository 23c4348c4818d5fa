"""Opening of an environment's players (`backend.Player`, one for each language), with tokenizer and spaces."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from typing import cast

from gymnasium import spaces

from arramon_client.environments.arguments import listed
from arramon_client.environments.backend import Backend, Player, PlayerSettings
from arramon_client.environments.errors import BadArgument, NoBackend
from arramon_client.environments.options import Options
from arramon_client.environments.spaces import OBSERVED_SENSORS, ObservationConverter, merge_bounds, observation_space
from arramon_client.environments.tokens import ByteTokenizer, Tokenizer, WordTokenizer
from arramon_client.errors import ArramonClientError, UsageError
from arramon_client.local.embedded import default_data

BACKENDS = "arramon.environments"
"""Entry-point group in which the server package registers its backend."""


@dataclass(frozen=True)
class PlayerSet:
    """An environment's players, one for each language, with their settings and tokenizer.

    Attributes:
        players: players by language; all play the same split.
        settings: settings of the first player.
        tokenizer: tokenizer of the instructions.
        options: the options as given, with an absolute data folder.
    """

    players: Mapping[str, Player]
    settings: PlayerSettings
    tokenizer: Tokenizer
    options: Options

    @property
    def player(self) -> Player:
        """The player of the first language."""
        return next(iter(self.players.values()))

    def observation_space(self) -> spaces.Dict:
        """Return a new observation space that contains the observations in every language."""
        texts = merge_bounds(player.split.texts[language] for language, player in self.players.items())
        steps = self.player.split.steps_per_phase
        return observation_space(self.settings, texts, steps, self.tokenizer, self.options.observe)

    def translator(self) -> ObservationConverter:
        """Return a converter to observations of that space."""
        return ObservationConverter(self.tokenizer, self.options.observe)


def open_players(options: Options) -> PlayerSet:
    """Open the players of an environment, one for each of its languages.

    Raises:
        NoBackend: if no host is named, and the server package is not installed.
        BadArgument: if the split does not have what the options name.
        ArramonClientError: if the host does not answer, or refuses.
    """
    backend = open_backend(options)
    settings = PlayerSettings(
        language=options.languages[0],
        split=options.split,
        sensors=tuple(name for name in OBSERVED_SENSORS if name in options.sensors),
        image_size=options.image_size,
        reward=options.reward or "none",
        expert=options.expert,
        phases=options.phases,
        turn=options.turn,
        start=options.start,
        steps_per_phase=options.steps_per_phase,
    )
    try:
        player = backend.player(settings)
        split = player.split
        for sensor in settings.sensors:
            if sensor not in split.sensors:
                raise BadArgument(
                    f"the split {split.name!r} does not offer the sensor {sensor!r}; it offers {listed(split.sensors)}"
                )
        if split.hidden and options.reward not in (None, "none"):
            raise BadArgument(f"the split {split.name!r} is hidden: it has no rewards; use reward='none'")
        if split.hidden and options.expert is not None:
            raise BadArgument(f"the split {split.name!r} is hidden: it has no expert; use expert=None")
        if options.reward is None and not split.hidden and options.server is None:
            settings = replace(settings, reward="sparse")
            player = backend.player(settings)
        players = {settings.language: player} | {
            language: backend.player(replace(settings, language=language)) for language in options.languages[1:]
        }
        tokenizer = _tokenizer(options, backend, players)
    except UsageError as error:
        raise BadArgument(str(error)) from error
    if options.server is None:
        options = replace(options, data=(options.data or default_data()).absolute())
    return PlayerSet(players, settings, tokenizer, options)


def open_backend(options: Options) -> Backend:
    """Return the backend of the host that the options name, or else the server package's backend.

    Raises:
        NoBackend: if no host is named, and the server package is not installed.
        ArramonClientError: if the host does not answer.
    """
    if options.server is not None:
        from arramon_client.environments.remote import RemoteBackend

        return RemoteBackend(options.server, options.access)
    make_backend = local_backend()
    try:
        return make_backend(options.data or default_data())
    except ArramonClientError as error:
        raise BadArgument(str(error)) from error


@cache
def local_backend() -> Callable[[Path], Backend]:
    """Return the server package's function from a data folder to a backend; cached, as the look-up takes milliseconds.

    Raises:
        NoBackend: if the server package is not installed.
    """
    registered = next(iter(entry_points(group=BACKENDS)), None)
    if registered is None:
        raise NoBackend(
            "without server=... an environment plays in this process, but arramon-server is not installed: install it, "
            "or name a host with server='HOST:PORT'"
        )
    return cast(Callable[[Path], Backend], registered.load())


def _tokenizer(options: Options, backend: Backend, players: Mapping[str, Player]) -> Tokenizer:
    if not isinstance(options.tokenizer, str):
        return options.tokenizer
    if options.tokenizer == "words":
        texts = (backend.instructions(options.split, language) for language in players)
        return WordTokenizer.of(text for some in texts for text in some)
    return ByteTokenizer(max(player.split.texts[language].longest_utf8 for language, player in players.items()))
