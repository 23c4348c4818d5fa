"""Generation of splits in the data folder, for `arramon-server generate`."""

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path

from arramon_dataset.generation.batches import EpisodeBatch, MakeWriter, batch_runner, make_batches
from arramon_dataset.generation.extra_sections import extra_sections
from arramon_dataset.generation.room_tasks import ROOM_SECTION, room_batches, room_ids
from arramon_dataset.generation.split_maker import GenerationProgress, SplitRequest, make_split
from arramon_dataset.generation.split_specs import EXTRA, SplitSpec
from arramon_dataset.parallel import processes_of
from arramon_dataset.plans import Plan, build_section, read_plan
from arramon_server.episodes.epoch_statement import parse_epoch_name
from arramon_server.episodes.split_secrets import host_secret
from arramon_server.episodes.splits import ROOMS_SPLIT, Split
from arramon_server.errors import BadInput
from arramon_server.sim.section import Section

NO_TRIAL = "not tried by the follower"
"""Suffix of a split's `source` if the follower did not play its episodes."""

OnProgress = Callable[[GenerationProgress], None]
"""Called with the progress of a split, in the thread that generates."""


def generate(
    data: Path,
    plans: Sequence[SplitSpec],
    *,
    scale: float = 1.0,
    seed: int = 0,
    jobs: int = 0,
    make_writer: MakeWriter,
    on_progress: OnProgress,
    tried: bool = True,
    secret: str = "",
    further: Mapping[str, str] | None = None,
) -> list[Split]:
    """Generate splits. Each is written when it is complete, and only then replaces an existing split of that name.

    The next call resumes an incomplete split from its checkpoint in the data folder (see `checkpoint`).
    The same seed, scale and version of the project give the same bytes on any machine. A hidden split is seeded by the
    host's secret instead of `seed` (see `secret`).

    Args:
        data: the data folder.
        plans: specifications of the splits.
        scale: share of each split's size, in (0, 1].
        seed: seeds furniture, facades and episodes, and the street plans of `train_extra`.
        jobs: number of processes; 0 for one per core.
        make_writer: creates the instruction writer of a process.
        on_progress: called with the progress.
        tried: whether the writer lets an agent play each episode; otherwise the split's header says so.
        secret: seeds hidden splits; empty for the host's own secret.
        further: codes of the languages that the writer adds where they can express an episode, and what the split's
            header calls each, where it counts the episodes that have them.

    Returns:
        The splits that were written.

    Raises:
        BadInput: if the scale or the number of jobs is out of range, a secret is given but no split is hidden, or none
            is given for an epoch of a hidden split.
        BadFile: if the file of the host's secret is malformed, or readable by other users.
        StorageError: if the data folder cannot be written.
        Conflict: if another process is generating one of the splits in this data folder.
        ArraMonError: if no valid episode is found for an id.
    """
    number = processes_of(jobs)
    for plan in plans:
        plan.count(scale)  # Checks the scale before generation starts.
    _check_secret(plans, secret)
    with batch_runner(number) as run:
        orders = (_order(data, plan, scale, seed, make_writer, tried, secret, further or {}) for plan in plans)
        return [make_split(data, order, run, on_progress) for order in orders]


def generate_rooms(data: Path, count: int, *, seed: int = 0, jobs: int = 0, on_progress: OnProgress) -> Split:
    """Generate the training split `rooms`: assembly tasks without a city, in every language.

    Args:
        data: the data folder.
        count: number of tasks.
        seed: of all tasks. A smaller count gives a prefix of a larger one.
        jobs: number of processes; 0 for one per core.
        on_progress: called with the progress.

    Raises:
        BadInput: if the number of tasks or of jobs is out of range.
        StorageError: if the data folder cannot be written.
        Conflict: if another process is generating this split in this data folder.
    """
    if count < 1:
        raise BadInput(f"the number of room tasks is {count}; expected at least 1")
    order = SplitRequest(
        name=ROOMS_SPLIT,
        source=f"room tasks alone, seed {seed}, {NO_TRIAL}",
        key=(ROOMS_SPLIT, seed),
        episode_ids=room_ids(count),
        sections=[ROOM_SECTION],
        batches=lambda missing: room_batches(seed, missing),
        training=True,
    )
    with batch_runner(processes_of(jobs)) as run:
        return make_split(data, order, run, on_progress)


def _check_secret(plans: Sequence[SplitSpec], secret: str) -> None:
    if secret and not any(plan.hidden for plan in plans):
        names = ", ".join(plan.name for plan in plans)
        raise BadInput(f"a secret was given, but secrets seed hidden splits only, and {names} is not hidden")
    for plan in plans:
        if not secret and parse_epoch_name(plan.name):
            raise BadInput(
                f"the epoch {plan.name!r} needs its own secret: give it with --secret once it is "
                "revealed, or open an epoch with `arramon-server epoch open`"
            )


def _order(
    data: Path,
    plan: SplitSpec,
    scale: float,
    seed: int,
    make_writer: MakeWriter,
    tried: bool,
    secret: str,
    further: Mapping[str, str],
) -> SplitRequest:
    key = (secret or host_secret(data)) if plan.hidden else str(seed)
    built = extra_sections(key, plan.sections) if plan.name == EXTRA else _own_sections(key, plan.sections)
    episodes = dict(plan.episodes(scale))

    def batches(missing: Sequence[str]) -> list[EpisodeBatch]:
        wanted = set(missing)
        left = [(name, section) for name, section in episodes.items() if name in wanted]
        return make_batches(key, plan.name, left, built, make_writer)

    source = f"scale {scale:g}, " + ("from the host's secret" if plan.hidden else f"seed {seed}")
    return SplitRequest(
        name=plan.name,
        source=source if tried else f"{source}, {NO_TRIAL}",
        key=(key, make_writer.__module__, getattr(make_writer, "__qualname__", repr(make_writer))),
        episode_ids=sorted(episodes, key=int),
        sections=[section for _, section in built.values()],
        batches=batches,
        hidden=plan.hidden,
        training=plan.training,
        further=further,
    )


def _own_sections(key: str, names: Sequence[str]) -> dict[str, tuple[Plan, Section]]:
    return {name: (plan := read_plan(name), _section(key, plan)) for name in names}


@lru_cache(maxsize=16)
def _section(key: str, plan: Plan) -> Section:
    """Return a section. Cached: splits share sections, and building one takes a second or two."""
    return build_section(plan, key)
