"""Quotas over gRPC: limits on runs and streams, what counts, and concurrent requests."""

import re
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_server import cli
from arramon_server.runs.accounts.callers import Role
from arramon_server.runs.accounts.quotas import Quota, Quotas
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from tests import tiny
from tests.api.people import Person, token_of
from tests.api.player import Player, create
from tests.api.test_runs import refused
from tests.serving import METADATA, Server


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """One with the server's own limits; each test has a participant of its own, with limits of their own."""
    data = tmp_path_factory.mktemp("data")
    with serving(data) as started:
        yield started


@contextmanager
def serving(data: Path, *limits: str) -> Iterator[Server]:
    tiny.write(data)
    tiny.write(data, "secret", 3, hidden=True)
    server = Server(data, "127.0.0.1:0", "--steps", "8", *limits)
    try:
        yield server
    finally:
        assert server.stop() == 0


@contextmanager
def journal(data: Path) -> Iterator[Database]:
    database = Database(f"sqlite:///{data / 'journal.db'}")
    try:
        yield database
    finally:
        database.close()


@contextmanager
def limited(server: Server, name: str, **limits: int | None) -> Iterator[Person]:
    """A new participant, who has these limits on the split "tiny"."""
    token = token_of(server.data, name)
    with journal(server.data) as database:
        Quotas(database, lambda *_: Quota()).set(name, "tiny", limits)
    with Person(server.address, token) as person:
        yield person


def exhausted(call: Callable[[], object]) -> str:
    code, said = refused(call)
    assert code == grpc.StatusCode.RESOURCE_EXHAUSTED
    return said


def cancel(person: Person, run: pb.Run) -> None:
    person.stub.CancelRun(pb.CancelRunRequest(run_id=run.run_id), metadata=METADATA)


def quotas(person: Person) -> dict[str, pb.Quota]:
    account = person.stub.GetAccount(pb.GetAccountRequest(), metadata=METADATA)
    return {quota.split: quota for quota in account.quotas}


def test_daily_run_limit_names_the_time_of_the_next_run(server: Server) -> None:
    with limited(server, "daily", runs_per_day=2) as ann:
        first, second = create(ann.stub), create(ann.stub)
        cancel(ann, second)  # what was created was created
        said = exhausted(lambda: create(ann.stub))
        found = re.fullmatch(
            rf"you have on split 'tiny' 2 runs of the last 24 hours \({second.run_id}, {first.run_id}\); "
            r"the limit is 2: the next is possible at (.*) UTC",
            said,
        )
        assert found is not None
        following = datetime.strptime(found[1], "%Y-%m-%d %H:%M:%S").replace(tzinfo=UTC)
        assert following == datetime.fromisoformat(first.created_at) + timedelta(days=1)
        assert create(ann.stub, split="secret").split == "secret"  # each split has its own
        with journal(server.data) as database, database.write() as connection:
            long_ago = datetime.now(UTC) - timedelta(hours=24, seconds=1)
            row = tables.runs.c.run_id == first.run_id
            connection.execute(tables.runs.update().where(row).values(created_at=long_ago))
        assert create(ann.stub).participant == "daily"
        assert (quotas(ann)["tiny"].runs_today, quotas(ann)["tiny"].runs) == (2, 3)


def test_total_run_limit_excludes_runs_with_server_faults(server: Server) -> None:
    with limited(server, "once", runs_in_all=1) as ann:
        run = create(ann.stub)
        assert exhausted(lambda: create(ann.stub)) == (
            f"you have on split 'tiny' 1 run ({run.run_id}); the limit is 1 in total"
        )
        with journal(server.data) as database, database.write() as connection:
            its = (tables.episodes.c.run_id == run.run_id) & (tables.episodes.c.ordinal == 0)
            connection.execute(tables.episodes.update().where(its).values(state="ENDED", cause="SERVER_FAULT"))
        assert quotas(ann)["tiny"].runs == 0
        create(ann.stub)
        exhausted(lambda: create(ann.stub))
        with Person(server.address, token_of(server.data, "bob")) as bob:
            assert create(bob.stub).participant == "bob"


def test_limit_on_unfinished_runs_is_enforced(server: Server) -> None:
    with limited(server, "single", runs_at_once=1) as ann:
        run = create(ann.stub, episodes=1)
        assert exhausted(lambda: create(ann.stub)) == (
            f"you have on split 'tiny' 1 unfinished run ({run.run_id}); the limit is 1 at once: "
            "the next is possible when one of them has ended, so play it to its end (`arramon-client --resume RUN`) or "
            "cancel it (`arramon-client cancel RUN`)"
        )
        with Player(ann.stub, run.run_id) as player:
            player.play(tiny.ACTIONS)
        cancel(ann, create(ann.stub))
        assert create(ann.stub).state == pb.RUN_STATE_RUNNING


def test_quota_refusal_names_the_latest_runs(server: Server) -> None:
    with limited(server, "busy", runs_at_once=6) as ann:
        runs = [create(ann.stub, episodes=1).run_id for _ in range(6)]
        assert f"6 unfinished runs ({', '.join(runs[:0:-1])} and others); the limit is 6 at once" in exhausted(
            lambda: create(ann.stub)
        )


def test_anonymous_quota_refusals_do_not_reveal_run_ids(tmp_path: Path) -> None:
    """Whoever knows the id of an anonymous run can play it."""
    tiny.write(tmp_path)
    limits = ("--runs-at-once", "1", "--streams-at-once", "1")
    server = Server(tmp_path, "127.0.0.1:0", "--anonymous", "--trust-proxy", *limits)
    try:
        with Person(server.address) as one, Person(server.address) as other:
            run = create(one.stub)
            said = exhausted(lambda: create(other.stub))
            assert said.startswith(
                "all callers without a token together have on split 'tiny' 1 unfinished run; the limit is 1 at once"
            )
            assert said.endswith("with a token, for which you can ask the host, you have a limit of your own")
            with Player(one.stub, run.run_id, player="one") as player:
                player.observation()
                said = exhausted(lambda: list(Player(one.stub, run.run_id, player="two").call))
                assert run.run_id not in said
    finally:
        assert server.stop() == 0


@pytest.mark.parametrize("limit", ["runs_in_all", "runs_at_once", "runs_per_day"])
def test_concurrent_run_creation_never_exceeds_the_limit(server: Server, limit: str) -> None:
    with limited(server, f"many {limit}", **{limit: 3}) as ann, ThreadPoolExecutor(12) as pool:

        def attempt(_: int) -> grpc.StatusCode:
            try:
                create(ann.stub)
            except grpc.RpcError as error:
                return error.code()
            return grpc.StatusCode.OK

        got = Counter(pool.map(attempt, range(24)))
        assert got == {grpc.StatusCode.OK: 3, grpc.StatusCode.RESOURCE_EXHAUSTED: 21}
        assert len(ann.stub.ListRuns(pb.ListRunsRequest(), metadata=METADATA).runs) == 3


def test_limits_can_be_set_per_split(tmp_path: Path) -> None:
    with (
        serving(tmp_path, "--runs-per-day", "secret=1", "--runs-at-once", "3,secret=0") as server,
        Person(server.address, token_of(tmp_path, "ann")) as ann,
    ):
        create(ann.stub, split="secret")
        assert "the limit is 1:" in exhausted(lambda: create(ann.stub, split="secret"))
        for _ in range(3):
            create(ann.stub)
        assert "the limit is 3 at once" in exhausted(lambda: create(ann.stub))
        found = {split: (quota.runs_per_day, quota.runs_at_once) for split, quota in quotas(ann).items()}
        assert found == {"secret": (1, 0), "tiny": (200, 3)}
        with journal(tmp_path) as database:  # what is set for one participant on one split holds beside that
            kept = Quotas(database, lambda _, split: Quota(runs_per_day=int(split == "secret")))
            kept.set("ann", "secret", {"runs_at_once": 5})
            assert kept.of("ann", "secret") == Quota(runs_per_day=1, runs_at_once=5)
        assert "the limit is 1:" in exhausted(lambda: create(ann.stub, split="secret"))


def limits(quota: pb.Quota) -> tuple[int, int, int, int]:
    return quota.runs_per_day, quota.runs_in_all, quota.runs_at_once, quota.streams_at_once


def test_participants_have_limits_where_the_host_sets_none(tmp_path: Path) -> None:
    with serving(tmp_path) as server:
        token = token_of(tmp_path, "ann")
        with Person(server.address, token) as ann:
            found = {split: limits(quota) for split, quota in quotas(ann).items()}
            assert found == {"secret": (3, 0, 3, 64), "tiny": (200, 0, 20, 64)}
            made = [create(ann.stub, split="secret") for _ in range(3)]
            assert "the limit is 3 at once" in exhausted(lambda: create(ann.stub, split="secret"))
            cancel(ann, made[0])
            assert "the limit is 3: the next is possible" in exhausted(lambda: create(ann.stub, split="secret"))
            for _ in range(20):
                create(ann.stub)
            assert "20 unfinished runs" in exhausted(lambda: create(ann.stub))
        with Person(server.address) as nobody:  # a user of the own machine, without a token
            assert {limits(quota) for quota in quotas(nobody).values()} == {(0, 0, 0, 0)}
        with Person(server.address, token_of(tmp_path, "chair", Role.HOST)) as chair:
            assert {limits(quota) for quota in quotas(chair).values()} == {(0, 0, 0, 0)}


def test_callers_without_a_token_have_limits_together_on_a_server_for_others(tmp_path: Path) -> None:
    set_ = ("--anonymous", "--trust-proxy", "--runs-at-once", "tiny=2")
    with serving(tmp_path, *set_) as server, Person(server.address) as one:
        found = {split: limits(quota) for split, quota in quotas(one).items()}
        assert found == {"secret": (3, 0, 3, 64), "tiny": (200, 0, 2, 64)}


def test_limit_on_open_streams_is_enforced(tmp_path: Path) -> None:
    with (
        serving(tmp_path, "--streams-at-once", "1") as server,
        Person(server.address, token_of(tmp_path, "ann")) as ann,
    ):
        run = create(ann.stub)
        with Player(ann.stub, run.run_id, player="one") as one:
            one.observation()
            assert quotas(ann)["tiny"].streams == 1
            assert exhausted(lambda: list(Player(ann.stub, run.run_id, player="two").call)) == (
                f"you have on split 'tiny' 1 open stream of {run.run_id}; the limit is 1 at once: "
                "the next is possible when one is closed, by itself if its client vanished"
            )
            with Player(ann.stub, run.run_id, player="one") as again:  # takes the place of its own
                again.observation()
                assert quotas(ann)["tiny"].streams == 1
        while quotas(ann)["tiny"].streams:
            pass
        with Player(ann.stub, run.run_id, player="two", adopt=True) as two:
            two.observation()
            assert quotas(ann)["tiny"].streams == 1


def test_streams_of_a_killed_server_stop_counting(tmp_path: Path) -> None:
    with serving(tmp_path, "--streams-at-once", "1") as server:
        token = token_of(tmp_path, "ann")
        with Person(server.address, token) as ann:
            run = create(ann.stub)
            with Player(ann.stub, run.run_id, player="one") as one:
                one.observation()
                server.kill()
        with journal(tmp_path) as database:
            assert len(database.read(tables.streams.select())) == 1
        server.start()
        with Person(server.address, token) as ann:
            while quotas(ann)["tiny"].streams:  # until its lease has run out
                pass
            with Player(ann.stub, run.run_id, player="two", adopt=True) as two:
                two.observation()


def test_quota_command_changes_a_participants_limits(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def quota(*arguments: str) -> tuple[int, str, str]:
        status = cli.main(["quota", *arguments, "--data", str(tmp_path)])
        said = capsys.readouterr()
        return status, said.out, said.err

    header = "participant\tsplit\truns_per_day\truns_in_all\truns_at_once\tstreams_at_once\n"
    with serving(tmp_path, "--runs-in-all", "1") as server, Person(server.address, token_of(tmp_path, "ann")) as ann:
        create(ann.stub)
        exhausted(lambda: create(ann.stub))
        assert quota("ann", "tiny", "--runs-in-all", "2") == (0, f"{header}ann\ttiny\t200\t2\t20\t64\n", "")
        create(ann.stub)
        exhausted(lambda: create(ann.stub))
        assert quota("ann", "tiny", "--runs-in-all", "0")[0] == 0
        create(ann.stub)
        assert quota("ann", "tiny", "--runs-in-all", "default")[0] == 0
        exhausted(lambda: create(ann.stub))
        with Person(server.address) as one, Person(server.address) as other:  # they share a quota
            first = create(one.stub, participant="one")
            exhausted(lambda: create(other.stub))
            assert quota("anonymous", "tiny", "--runs-in-all", "2")[0] == 0
            second = create(other.stub, participant="other")
            assert exhausted(lambda: create(one.stub)) == (
                "all callers without a token together have on split 'tiny' 2 runs "
                f"({second.run_id}, {first.run_id}); the limit is 2 in total"
            )
        with Person(server.address, token_of(tmp_path, "chair", Role.HOST)) as chair:
            for _ in range(3):  # hosts have no limits
                create(chair.stub)
    assert quota("list") == (
        0,
        f"{header}ann\ttiny\t200\tany\t20\t64\nanonymous\ttiny\tany\t2\tany\tany\n",
        "",
    )
    for arguments, said in (
        (("eve", "tiny"), "there is no participant 'eve'; `arramon-server token list` shows them"),
        (
            ("eve", "tiny", "--runs-in-all", "1"),
            "there is no participant 'eve'; `arramon-server token list` shows them",
        ),
        (("ann", "val"), f"there is no split 'val' in {tmp_path}; there are secret, tiny"),
        (("ann",), "the split is missing: arramon-server quota PARTICIPANT SPLIT, or arramon-server quota list"),
        (
            ("ann", "tiny", "--runs-in-all", "9" * 12),
            f"runs_in_all is {'9' * 12}, expected 0 (no limit) to 1000000000",
        ),
    ):
        assert quota(*arguments) == (1, "", f"arramon-server: {said}\n")
