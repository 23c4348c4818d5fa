"""Snapshots of environments: arguments and actions so far, from which a copy is rebuilt by replaying the actions.

Snapshots make an environment in this process picklable and copyable in the middle of an episode. The replay renders
nothing.
"""

import copy
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

from arramon_client.environments.backend import Player
from arramon_client.environments.episodes import Episodes
from arramon_client.environments.errors import CannotCopy
from arramon_client.environments.options import Options
from arramon_client.environments.players import open_players
from arramon_client.environments.tokens import Tokenizer
from arramon_client.errors import ArramonClientError


@dataclass(frozen=True)
class Snapshot:
    """State from which an environment's episodes are rebuilt.

    Attributes:
        options: options, with the tokenizer as an object and an absolute data folder.
        data_hashes: hash of the split's data, by language.
        begun: language, id and seed of the current episode; None before the first.
        actions: actions of the current episode, in order.
        advised: the expert's action in each state, in order; empty without an expert.
        is_over: whether the current episode has ended, or none has begun.
        is_closed: whether the environment was closed.
    """

    options: Options
    data_hashes: Mapping[str, str]
    begun: tuple[str, str | None, int] | None
    actions: tuple[int, ...]
    advised: tuple[int, ...]
    is_over: bool
    is_closed: bool = False


class Copyable(ABC):
    """Base class of environments that are pickled and copied by means of a snapshot of their episodes.

    Attributes:
        REBUILT: names of the attributes that `_set_episodes` sets, and a copy rebuilds.
    """

    REBUILT: ClassVar[tuple[str, ...]]
    _episodes: Episodes

    @abstractmethod
    def _set_episodes(self, episodes: Episodes) -> None:
        """Set the attributes that a copy rebuilds instead of copying."""

    def __getstate__(self) -> dict[str, Any]:
        kept = {name: value for name, value in self.__dict__.items() if name not in self.REBUILT}
        return {**kept, "snapshot": take_snapshot(self._episodes)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update({name: value for name, value in state.items() if name != "snapshot"})
        self._set_episodes(restore_snapshot(state["snapshot"]))

    def __copy__(self) -> Self:
        """Return a deep copy, which does not share the random generators of the spaces and the episodes."""
        return copy.deepcopy(self)

    @property
    def tokenizer(self) -> Tokenizer:
        """The tokenizer of the instructions."""
        return self._episodes.opened.tokenizer

    @property
    def player(self) -> Player:
        """The player of the current episode, with its split, labels and hash chain."""
        return self._episodes.player


def take_snapshot(episodes: Episodes) -> Snapshot:
    """Return a snapshot of the episodes of an environment.

    Raises:
        CannotCopy: if the environment is on a host, where its run goes on.
    """
    opened = episodes.opened
    if opened.options.server is not None:
        raise CannotCopy(
            f"an environment on a host cannot be pickled or copied, as its run goes on at {opened.options.server}: "
            "play in this process (server=None), or make another environment"
        )
    return Snapshot(
        options=replace(opened.options, tokenizer=opened.tokenizer),
        data_hashes={language: player.split.data_hash for language, player in opened.players.items()},
        begun=episodes.begun,
        actions=tuple(episodes.actions),
        advised=tuple(episodes.advised),
        is_over=episodes.is_over,
        is_closed=episodes.closed,
    )


def restore_snapshot(snapshot: Snapshot) -> Episodes:
    """Return the episodes of a snapshot, with the current episode in the same state.

    Raises:
        CannotCopy: if the data no longer exists, or has changed since.
    """
    try:
        opened = open_players(snapshot.options)
    except ValueError as error:
        raise CannotCopy(f"the environment cannot be restored: {error}") from error
    for language, player in opened.players.items():
        if player.split.data_hash != snapshot.data_hashes[language]:
            raise CannotCopy(
                f"the environment cannot be restored: the split {player.split.name!r} in {opened.options.data} is "
                f"{player.split.data_hash[:12]} now, and was {snapshot.data_hashes[language][:12]}"
            )
    episodes = Episodes(opened)
    if snapshot.begun is not None:
        try:
            episodes.open(*snapshot.begun)
            _replay(episodes, snapshot)
        except ArramonClientError as error:
            raise CannotCopy(f"the environment cannot be restored: {error}") from error
    if snapshot.is_closed:
        episodes.close()
    return episodes


def _replay(episodes: Episodes, snapshot: Snapshot) -> None:
    """Replay the actions of a snapshot, and query the expert wherever its later advice depends on the query."""
    first = len(snapshot.actions) + 1
    if snapshot.options.expert == "reference":  # It plans once, in a state that depends on the path there.
        first = 0
    elif snapshot.options.expert is not None:  # It plans again after an action that differs from its advice.
        taken = enumerate(zip(snapshot.actions, snapshot.advised, strict=False), start=1)
        first = max((number for number, (action, advice) in taken if action != advice), default=0)
    player = episodes.player
    for number, action in enumerate(snapshot.actions):
        if number >= first:
            player.expert_action()
        player.advance(action)
    if first <= len(snapshot.actions) < len(snapshot.advised):
        player.expert_action()
    episodes.actions, episodes.advised = list(snapshot.actions), list(snapshot.advised)
    episodes.is_over = snapshot.is_over
