"""`arramon-server token`: made for scripts, and nothing of a token is ever shown again."""

import re
from pathlib import Path

import pytest

from server import cli


def test_tokens_from_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def token(*arguments: str) -> tuple[int, str, str]:
        status = cli.main(["token", *arguments, "--data", str(tmp_path)])
        said = capsys.readouterr()
        return status, said.out, said.err

    status, made, remark = token("create", "Lab One", "--expires", "30", "--note", "to Ann")
    assert status == 0
    found = re.fullmatch(r"arramon_([0-9a-f]{12})_([\w-]{43})\n", made)
    assert found is not None
    assert remark == "Lab One (participant); keep it safe, it is shown this once:\n"
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
        "arramon-server: there is a participant 'Lab One', whom 'lab one' can be taken for\n",
    )
