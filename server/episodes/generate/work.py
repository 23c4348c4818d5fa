"""Makes a split's episodes on several cores: the same ones, in the same order, whatever their number."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from multiprocessing.connection import wait

from server.episodes.episode import Episode
from server.episodes.generate.check import problems
from server.episodes.generate.site import Site, Writer
from server.errors import ArraMonError
from server.sim.section import Section

ATTEMPTS = 100
"""Drafts made of one episode before it is given up."""

BATCH = 6
"""Episodes in one order."""

SECTIONS_KEPT = 7
"""Sections that a process keeps at hand."""

MakeWriter = Callable[[], Writer]
"""Makes a process's writer. A function at the top of a module, as its name is what travels to the processes."""


@dataclass(frozen=True, slots=True)
class Order:
    """Some episodes of one section to make.

    Attributes:
        seed: draws the episodes.
        split: its name.
        section: where they take place.
        episode_ids: of the episodes.
        make_writer: see `MakeWriter`.
    """

    seed: str
    split: str
    section: Section
    episode_ids: tuple[str, ...]
    make_writer: MakeWriter


@dataclass(frozen=True, slots=True)
class Made:
    """An episode, and how many drafts it took, the last one included."""

    episode: Episode
    attempts: int


Run = Callable[[Sequence[Order]], Iterator[list[Made]]]


@contextmanager
def workshop(jobs: int) -> Iterator[Run]:
    """What carries out orders, in order, on `jobs` cores: in this process for one, otherwise in processes of its own.

    Raises:
        ArraMonError: while it runs, if one of its processes dies.
    """
    if jobs == 1:
        yield lambda orders: map(fulfil, orders)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context, initializer=_end_with_parent) as pool:

        def run(orders: Sequence[Order]) -> Iterator[list[Made]]:
            try:
                yield from pool.map(fulfil, orders)
            except BrokenProcessPool as error:
                raise ArraMonError("a process that made episodes died, perhaps for want of memory") from error

        try:
            yield run
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def orders_of(
    seed: str,
    split: str,
    episodes: Iterable[tuple[str, str]],
    sections: Mapping[str, Section],
    make_writer: MakeWriter,
) -> list[Order]:
    """Orders for pairs of an episode's id and its section's, section after section; `sections` are by id."""
    by_section: dict[str, list[str]] = {}
    for episode_id, section in episodes:
        by_section.setdefault(section, []).append(episode_id)
    return [
        Order(seed, split, sections[section], tuple(ids[first : first + BATCH]), make_writer)
        for section, ids in by_section.items()
        for first in range(0, len(ids), BATCH)
    ]


def fulfil(order: Order) -> list[Made]:
    """Makes the episodes of an order, one after the other."""
    site, writer = _site(order.section), _writer(order.make_writer)
    return [_make(order, episode_id, site, writer) for episode_id in order.episode_ids]


def _make(order: Order, episode_id: str, site: Site, writer: Writer) -> Made:
    for attempt in range(ATTEMPTS):
        names = (order.seed, order.split, episode_id, attempt)
        draft = site.drawer.draw(episode_id, (*names, "draft"))
        if problems(draft, site.solids, site.world):
            continue
        instructions = writer(draft, site, (*names, "words"))
        if instructions is not None:
            return Made(draft.spoken(instructions), attempt + 1)
    raise ArraMonError(f"no good episode {episode_id} of split {order.split} was found in {ATTEMPTS} attempts")


@lru_cache(maxsize=SECTIONS_KEPT)
def _site(section: Section) -> Site:
    return Site(section)


@lru_cache(maxsize=1)
def _writer(make: MakeWriter) -> Writer:
    return make()


def _end_with_parent() -> None:
    """Ends this process when its parent is gone, however it went: a pool's processes would wait for ever.

    An interrupt at the keyboard is for the parent.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, name="end-with-parent", daemon=True).start()
