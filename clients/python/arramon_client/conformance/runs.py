"""Checks of runs: created as requested, read back, listed, and in the split's fixed order."""

from datetime import datetime, timedelta

from arramon.v1 import evaluation_pb2 as pb
from arramon_client.conformance.assertions import expect, expect_equal, need
from arramon_client.conformance.raw_stream import forfeit
from arramon_client.conformance.suite import check
from arramon_client.conformance.target import AGENT, Target
from arramon_client.transport.incoming import RUN_ID


@check("runs.created", runs=1)
def created(target: Target) -> None:
    """CreateRun returns the run as requested, running, with the server's limits and the split's data hash."""
    sensors = target.pose_sensors()
    run = target.create(sensors=sensors)
    expect(RUN_ID.fullmatch(run.run_id), f"the run's id is {run.run_id!r}, expected 32 hexadecimal digits")
    expect(run.participant, "the run has no participant, expected a name")
    episodes = target.available if target.split.hidden else 1
    for name, expected in (
        ("agent", AGENT),
        ("split", target.split.name),
        ("language", target.language),
        ("sensors", sensors),
        ("limits", target.info.limits),
        ("data_hash", target.split.data_hash),
        ("state", pb.RUN_STATE_RUNNING),
        ("episodes", episodes),
        ("episodes_ended", 0),
        ("steps", 0),
        ("ended_at", ""),
    ):
        found = getattr(run, name)
        expect_equal(f"{name} of a new run", list(found) if name == "sensors" else found, expected)
    check_time("created_at", run.created_at)
    expect_equal("the run as GetRun returns it", target.get(run), run)


@check("runs.account", runs=1)
def owned(target: Target) -> None:
    """A run created with a token belongs to the token's participant."""
    need(target.server.access.token, "the suite was given no token; --token-file would make it run")
    account = target.call("GetAccount", pb.GetAccountRequest())
    expect(account.participant, "GetAccount names no participant for this token, expected a name")
    expect_equal("the participant of the run", target.create().participant, account.participant)


@check("runs.listed", runs=2)
def listed(target: Target) -> None:
    """ListRuns returns the caller's runs, latest first, page by page, each once."""
    made = [target.create().run_id, target.create().run_id]
    pages: list[list[pb.Run]] = []
    token = ""
    while len(pages) < 20 and (token or not pages):
        page = target.call("ListRuns", pb.ListRunsRequest(page_size=1, page_token=token))
        if not pages and not page.runs and not target.server.access.token:
            need(False, "the server lists no runs of anonymous callers; --token-file would make it run")
        expect(len(page.runs) <= 1, f"a page of at most 1 run has {len(page.runs)}")
        pages.append(list(page.runs))
        token = page.next_page_token
        if set(made) <= {run.run_id for runs in pages for run in runs}:
            break
    runs = [run for page in pages for run in page]
    ids = [run.run_id for run in runs]
    expect(len(set(ids)) == len(ids), f"the pages list a run twice: {', '.join(ids)}")
    missing = set(made) - set(ids)
    expect(not missing, f"the latest {len(ids)} runs lack {', '.join(sorted(missing))}, which was just created")
    times = [run.created_at for run in runs]
    expect(
        ids.index(made[1]) < ids.index(made[0]),
        "an earlier run is listed before a later one, expected the latest first",
    )
    expect(times == sorted(times, reverse=True), f"the runs listed were created at {times}, expected the latest first")


@check("runs.order", runs=2)
def order(target: Target) -> None:
    """A run of N episodes has the first N episodes in the split's fixed order."""
    _need_open(target)
    sets = []
    for number in (1, 2):
        with target.play(target.create(episodes=number), number) as stream:
            stream.next("opened")
            sets.append({stream.observation().episode_id for _ in range(number)})
    first, both = sets
    expect(len(both) == 2, f"a run of 2 episodes offered {sorted(both)}, expected 2")
    expect(
        first < both, f"a run of 1 episode has {sorted(first)}, a run of 2 has {sorted(both)}, expected it among them"
    )


@check("runs.chosen", runs=2)
def chosen(target: Target) -> None:
    """A run of named episodes has exactly these, in the order in which they were named."""
    _need_open(target)
    with target.play(target.create(episodes=2), 2) as stream:
        stream.next("opened")
        named = [stream.observation().episode_id for _ in range(2)][::-1]
    run = target.create(episodes=0, episode_ids=named)
    expect_equal("the number of episodes of a run of 2 named ones", run.episodes, 2)
    found = []
    with target.play(run) as stream:
        stream.next("opened")
        for _ in named:
            found.append(stream.observation().episode_id)
            stream.send(forfeit(found[-1]))
            stream.next("episode_ended")
    expect_equal("the list of episodes played", found, named)


@check("runs.arguments", runs=1)
def arguments(target: Target) -> None:
    """A run records its agent's arguments, sorted by name."""
    given = [pb.AgentArgument(name="width", value=""), pb.AgentArgument(name="beam", value="4 or more")]
    run = target.create(agent_arguments=given)
    found = [(argument.name, argument.value) for argument in run.agent_arguments]
    expect_equal("the list of the agent's arguments", found, [("beam", "4 or more"), ("width", "")])


@check("runs.code", runs=1)
def code(target: Target) -> None:
    """A run records where its agent's code is."""
    given = pb.Code(url="https://example.org/agent", commit="0123456789" * 4, image=f"sha256:{'0123456789abcdef' * 4}")
    run = target.create(code=given)
    for name in ("url", "commit", "image"):
        expect_equal(f"the code's {name}", getattr(run.code, name), getattr(given, name))


def _need_open(target: Target) -> None:
    named = f"the split {target.split.name!r}"
    need(not target.split.hidden, f"{named} is hidden and played whole; an open one would make it run")


def check_time(name: str, text: str) -> None:
    """Check that a text is a time as in RFC 3339, in UTC."""
    try:
        time = datetime.fromisoformat(text)
    except ValueError:
        time = None
    is_utc = time is not None and time.utcoffset() == timedelta(0)
    expect(is_utc, f"{name} is {text!r}, expected a time by RFC 3339 in UTC")


CHECKS = (created, owned, listed, order, chosen, arguments, code)
