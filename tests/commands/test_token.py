"""`arramon-server token`: creation, listing and revocation; a token is shown only once."""

import re
from pathlib import Path

import pytest

from arramon_server import cli
from tests import tiny


def test_tokens_are_created_listed_and_revoked_by_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tiny.write(tmp_path)

    def token(*arguments: str) -> tuple[int, str, str]:
        status = cli.main(["token", *arguments, "--data", str(tmp_path)])
        said = capsys.readouterr()
        return status, said.out, said.err

    status, made, remark = token("create", "Lab One", "--expires", "30", "--note", "to Ann")
    assert status == 0
    found = re.fullmatch(r"arramon_([0-9a-f]{12})_([\w-]{43})\n", made)
    assert found is not None
    assert remark == "token for Lab One (participant); keep it safe, it is shown only once:\n"
    assert token("create", "chair", "--role", "host")[0] == 0

    status, listed, _ = token("list")
    lines = [re.split(r" {2,}", line) for line in listed.splitlines()]
    assert (status, lines[0]) == (0, ["id", "participant", "role", "created", "expires", "revoked", "note"])
    assert [line[1:3] for line in lines[1:]] == [["Lab One", "participant"], ["chair", "host"]]
    assert (lines[1][0], lines[1][5], lines[1][6]) == (found[1], "-", "to Ann")
    assert lines[2][4] == "-"
    assert found[2] not in listed

    assert token("revoke", found[1])[:2] == (0, f"token {found[1]} of Lab One is revoked\n")
    revoked_at = re.split(r" {2,}", token("list")[1].splitlines()[1])[5]
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\dZ", revoked_at)
    assert token("revoke", found[1])[0] == 0  # once more changes nothing
    assert token("revoke", "000000000000") == (
        1,
        "",
        "arramon-server: there is no token '000000000000'; `arramon-server token list` shows them\n",
    )
    assert token("create", "lab one") == (
        1,
        "",
        "arramon-server: the name 'lab one' can be confused with that of the participant 'Lab One'\n",
    )


COMMANDS = (
    ("token", "create", "Ann"),
    ("token", "list"),
    ("token", "revoke", "000000000000"),
    ("quota", "list"),
    ("quota", "Ann", "tiny", "--runs-per-day", "1"),
    ("import", "file"),
    ("export", "file"),
    ("runs",),
    ("runs", "cancel", "r"),
    ("key",),
    ("key", "--all"),
    ("rescore", "--all"),
)


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_commands_refuse_folders_that_are_not_data_folders(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: tuple[str, ...]
) -> None:
    wrong, missing = tmp_path / "wrong", tmp_path / "missing"
    wrong.mkdir()
    (wrong / "notes.txt").write_text("of something else")
    for data, said in ((missing, f"no folder {missing}: "), (wrong, f"{wrong} is not a data folder: it holds ")):
        assert cli.main([*command, "--data", str(data)]) == 1
        shown = capsys.readouterr()
        assert shown.out == ""
        assert shown.err.startswith(f"arramon-server: {said}")
        assert "--data" in shown.err
    assert [path.name for path in tmp_path.rglob("*")] == ["wrong", "notes.txt"]


def test_explicit_journal_path_needs_only_its_own_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "kept" / "journal.db"
    create = ["token", "create", "Ann", "--data", str(tmp_path / "missing"), "--journal", f"sqlite:///{file}"]
    assert cli.main(create) == 1
    said = f"arramon-server: the journal {file} cannot be created: there is no folder {file.parent}\n"
    assert capsys.readouterr().err == said
    file.parent.mkdir()
    assert cli.main(create) == 0


def test_missing_journal_is_reported_and_not_created(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tiny.write(tmp_path)
    assert cli.main(["runs", "--data", str(tmp_path)]) == 1
    said = f"there is no journal {tmp_path / 'journal.db'} yet; `arramon-server serve` creates it"
    assert capsys.readouterr().err == f"arramon-server: {said}\n"
    assert not (tmp_path / "journal.db").exists()


def test_token_can_be_created_before_the_first_start(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As README.md says it: `import-release` or `generate`, then `token create`, then `serve`."""
    tiny.write(tmp_path / "arramon-data")
    assert cli.main(["token", "create", "Lab One", "--data", str(tmp_path / "arramon-data")]) == 0
    assert capsys.readouterr().out.startswith("arramon_")
