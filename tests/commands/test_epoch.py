"""`arramon-server epoch`: a season of a hidden split, generated again by anyone from the secret that was revealed."""

import json
import stat
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from arramon_dataset import instruction_writer
from arramon_server import cli
from arramon_server.backup import back_up
from arramon_server.configuration.config import Config
from arramon_server.episodes.split_secrets import epoch_secret
from arramon_server.episodes.splits import read_split, split_folder, split_hash
from arramon_server.errors import BadFile
from arramon_server.process.lifecycle import check_secrets
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import CANCELLED
from tests.dataset.generation.small_section import make_plain_writer
from tests.played import play

SCALE = "0.0017"
"""Two episodes."""

NAME = "test_unseen_e1"


class Host:
    """A host's data folder, and the commands; instructions are written by a simple writer."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.data, self.elsewhere, self.list = folder / "data", folder / "elsewhere", folder / "epochs.json"
        self.data.mkdir()
        self._capsys = capsys

    def command(self, *words: str, data: Path | None = None) -> tuple[int, str, str]:
        self._capsys.readouterr()
        status = cli.main([*words, "--data", str(data or self.data)])
        said = self._capsys.readouterr()
        return status, said.out, said.err

    def does(self, *words: str, data: Path | None = None) -> str:
        status, out, err = self.command(*words, data=data)
        assert status == 0, err
        return out

    def refuses(self, *words: str, data: Path | None = None) -> str:
        status, out, err = self.command(*words, data=data)
        assert (status, out) == (1, "")
        assert "Traceback" not in err
        return err

    def opens(self) -> str:
        return self.does("epoch", "open", "test_unseen", "--scale", SCALE, "--jobs", "1")

    def listed(self) -> list[dict[str, Any]]:
        content = json.loads(self.does("epoch", "list", "--json"))
        assert (content["format"], content["version"]) == ("arramon-epochs", 1)
        self.list.write_text(json.dumps(content))
        found: list[dict[str, Any]] = content["epochs"]
        return found

    def change(self, **fields: object) -> Path:
        """Alter the list of epochs."""
        content = json.loads(self.list.read_text())
        content["epochs"][0] |= fields
        path = self.list.with_name("changed.json")
        path.write_text(json.dumps(content))
        return path


@pytest.fixture
def host(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Host:
    monkeypatch.setattr(instruction_writer, "make_instruction_writer", make_plain_writer)
    return Host(tmp_path, capsys)


def test_a_season_from_opening_to_verification(host: Host) -> None:
    said = host.opens()
    (epoch,) = host.listed()
    assert f"open: {NAME}, commitment {epoch['commitment']}" in said
    assert (epoch["split"], epoch["state"], epoch["secret"], epoch["command"]) == (NAME, "open", None, None)
    secret, data_hash = epoch_secret(host.data, NAME), split_hash(split_folder(host.data, NAME))
    public = (
        host.list.read_text() + said + "".join(p.read_text() for p in split_folder(host.data, NAME).rglob("*.json*"))
    )
    assert secret not in public
    assert stat.S_IMODE((host.data / "epochs" / f"{NAME}.secret").stat().st_mode) == 0o600
    assert "is not revealed yet" in host.refuses("epoch", "verify", str(host.list), NAME, data=host.elsewhere)

    assert host.does("epoch", "close", NAME) == f"closed: {NAME}; no new runs begin on it\n"
    assert host.listed()[0]["state"] == "closed"
    assert secret in host.does("epoch", "reveal", NAME)
    (epoch,) = host.listed()
    assert (epoch["state"], epoch["secret"]) == ("revealed", secret)
    assert epoch["command"] == f"arramon-server generate --split {NAME} --scale {SCALE} --secret {secret}"

    verified = host.does("epoch", "verify", str(host.list), NAME, "--jobs", "1", data=host.elsewhere)
    assert verified.endswith(": identical\n")
    assert split_hash(split_folder(host.elsewhere, NAME)) == data_hash
    again = host.elsewhere.with_name("again")
    host.does(*epoch["command"].split()[1:], "--jobs", "1", data=again)
    assert split_hash(split_folder(again, NAME)) == data_hash
    assert read_split(split_folder(again, NAME)).hidden


def test_each_epoch_has_the_next_number_and_a_secret_of_its_own(host: Host) -> None:
    host.opens()
    host.opens()
    assert [epoch["split"] for epoch in host.listed()] == ["test_unseen_e2", NAME]
    assert epoch_secret(host.data, NAME) != epoch_secret(host.data, "test_unseen_e2")
    one, other = (read_split(split_folder(host.data, name)) for name in (NAME, "test_unseen_e2"))
    assert list(one.episodes) == list(other.episodes)
    assert [one.episodes[key].turns for key in one.episodes] != [other.episodes[key].turns for key in other.episodes]
    lines = host.does("epoch", "list").splitlines()
    assert [line.split()[:3] for line in lines] == [
        ["epoch", "state", "episodes"], ["test_unseen_e2", "open", "2"], [NAME, "open", "2"],
    ]  # fmt: skip


def test_verification_finds_what_does_not_belong_together(host: Host) -> None:
    host.opens()
    host.does("epoch", "close", NAME)
    host.does("epoch", "reveal", NAME)
    (epoch,) = host.listed()
    other = "f" * 64

    def verify(path: Path, *more: str) -> tuple[int, str, str]:
        words = ("epoch", "verify", str(path), NAME, "--jobs", "1", *more)
        return host.command(*words, data=host.elsewhere)

    status, out, _ = verify(host.change(secret=other))
    assert (status, "the secret's SHA-256 is" in out) == (1, True)
    status, out, _ = verify(host.list, "--commitment", other)
    assert (status, f"but --commitment has {other}" in out) == (1, True)
    status, out, _ = verify(host.change(commitment=other))
    assert (status, f"but the list has {other}" in out) == (1, True)
    assert not host.elsewhere.exists()  # nothing was generated for those
    forged = json.loads(epoch["statement"]) | {"data_hash": other}
    from arramon_server.episodes.epoch_statement import commitment_of

    written = json.dumps(forged, separators=(",", ":"), sort_keys=True)
    changed = host.change(statement=written, commitment=commitment_of(written.encode()).hex())
    status, out, _ = verify(changed)
    assert (status, "the hash of the data is" in out) == (1, True)
    status, out, err = verify(host.list)
    assert (status, "expected a folder without it" in err) == (1, True)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("nonsense", "is not JSON, or was truncated"),
        ("[]", "is not a JSON object"),
        ("{}", "is not a list of epochs"),
        ('{"format": "arramon-epochs", "version": 2, "epochs": []}', "is not a list of epochs"),
        ('{"format": "arramon-epochs", "version": 1, "epochs": []}', f"there is no epoch '{NAME}' in"),
        ('{"format": "arramon-epochs", "version": 1, "epochs": [{"split": "test_unseen_e1"}]}', "expected a text"),
    ],
)
def test_verify_refuses_files_that_are_no_lists(host: Host, content: str, said: str) -> None:
    host.list.write_text(content)
    assert said in host.refuses("epoch", "verify", str(host.list), NAME)


def test_what_makes_no_sense_is_refused(host: Host) -> None:
    assert "there are no epochs of 'val_seen': expected a hidden split, test_unseen" in host.refuses(
        "epoch", "open", "val_seen"
    )
    assert "the scale is 2.0" in host.refuses("epoch", "open", "test_unseen", "--scale", "2")
    host.opens()
    assert f"there is no epoch 'nothing'; there are {NAME}" in host.refuses("epoch", "close", "nothing")
    assert "is open; close it first" in host.refuses("epoch", "reveal", NAME)
    host.does("epoch", "close", NAME)
    secret = host.data / "epochs" / f"{NAME}.secret"
    kept = secret.read_text()
    secret.write_text("f" * 64)
    assert "is not the secret that the host committed to" in host.refuses("epoch", "reveal", NAME)
    secret.unlink()
    assert "restore it from a backup" in host.refuses("epoch", "reveal", NAME)
    secret.write_text(kept)
    secret.chmod(0o644)
    with pytest.raises(BadFile, match="others can read it"):
        check_secrets(Config(data=host.data), {})


def test_runs_in_progress_are_named_and_forfeited(host: Host) -> None:
    host.opens()
    split = read_split(split_folder(host.data, NAME))
    with closing(Database(f"sqlite:///{host.data / 'journal.db'}")) as database:
        play(database, split, "going", dict.fromkeys(split.episodes, (0, 0)), over=False)
    status, _, err = host.command("epoch", "close", NAME)
    assert (status, "going" in err) == (0, True)
    assert "1 runs on the epoch 'test_unseen_e1' are still being played: going" in host.refuses("epoch", "reveal", NAME)
    _, _, err = host.command("epoch", "reveal", NAME, "--forfeit")
    assert "cancelled: going, walker by lab" in err
    with closing(Database(f"sqlite:///{host.data / 'journal.db'}")) as database:
        journal = Journal(database)
        assert journal.run("going").state == CANCELLED
        assert journal.progress("going").causes == {"FORFEITED": 2}
    assert host.listed()[0]["state"] == "revealed"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--split", NAME], "needs its own secret: give it with --secret"),
        (["--split", NAME, "--secret", "f" * 63], "--secret is neither 64 hexadecimal digits nor a readable file"),
        (["--split", NAME, "--secret", "F" * 64], "expected 64 hexadecimal digits"),
        (["--split", "val_seen", "--secret", "f" * 64], "secrets seed hidden splits only, and val_seen is not hidden"),
        (["--split", "val_seen_e1", "--secret", "f" * 64], "there are no epochs of 'val_seen'"),
    ],
)
def test_generate_refuses_secrets_that_fit_nothing(host: Host, words: list[str], said: str) -> None:
    assert said in host.refuses("generate", *words, "--scale", SCALE)


def test_a_hidden_split_is_generated_again_from_a_given_secret(host: Host) -> None:
    words = ("generate", "--split", "test_unseen", "--scale", SCALE, "--jobs", "1")
    host.does(*words)
    host.does(*words, "--secret", str(host.data / "secret"), data=host.elsewhere)
    assert split_hash(split_folder(host.data, "test_unseen")) == split_hash(split_folder(host.elsewhere, "test_unseen"))
    assert not (host.elsewhere / "secret").exists()


def test_backups_have_the_secrets_of_epochs(host: Host, tmp_path: Path) -> None:
    host.opens()
    back_up(Config(data=host.data), tmp_path / "backup")
    assert epoch_secret(tmp_path / "backup", NAME) == epoch_secret(host.data, NAME)
