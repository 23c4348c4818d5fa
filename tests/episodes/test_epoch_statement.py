"""Names, statements, commitments and secrets of epochs."""

import hashlib
import json
from dataclasses import replace

import pytest

from arramon_server.episodes.epoch_statement import (
    EpochStatement,
    check_secret,
    commitment_of,
    epoch_number,
    epoch_split_name,
    parse_epoch_name,
    read_statement,
    secret_digest,
)
from arramon_server.errors import BadFile, BadInput

SECRET = "0123456789abcdef" * 4

STATEMENT = EpochStatement(
    split="test_unseen_e2", base="test_unseen", sections=("7",), scale=0.25, episodes=301, tried=True,
    generator="0.1.0", sources="a" * 64, data_hash="b" * 64, secret_sha256=secret_digest(SECRET),
)  # fmt: skip

OTHERS = {
    "split": "test_unseen_e3", "base": "other", "sections": ("6",), "scale": 0.5, "episodes": 300, "tried": False,
    "generator": "0.1.1", "sources": "c" * 64, "data_hash": "c" * 64, "secret_sha256": "c" * 64, "version": 2,
}  # fmt: skip


def test_a_statement_is_canonical_json_with_everything_that_determines_the_split() -> None:
    written = STATEMENT.canonical_json()
    told = json.loads(written)
    assert list(told) == sorted(told)
    assert b" " not in written
    assert {"split", *OTHERS, "format"} == set(told)
    assert told["secret_sha256"] == hashlib.sha256(SECRET.encode()).hexdigest()
    assert SECRET.encode() not in written
    assert read_statement(written, "there") == STATEMENT
    assert commitment_of(written) == hashlib.sha256(written).digest()


@pytest.mark.parametrize(("field", "value"), OTHERS.items())
def test_the_commitment_binds_every_field(field: str, value: object) -> None:
    other = replace(STATEMENT, **{field: value})  # type: ignore[arg-type]
    assert commitment_of(other.canonical_json()) != commitment_of(STATEMENT.canonical_json())


def test_the_command_generates_the_split() -> None:
    assert STATEMENT.command == "arramon-server generate --split test_unseen_e2 --scale 0.25 --secret"
    assert "--no-trial" in replace(STATEMENT, tried=False).command


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"{}", "is not|missing|required"),
        (b"nonsense", "is not JSON"),
        (STATEMENT.canonical_json() + b" ", "not in canonical form"),
        (replace(STATEMENT, version=2).canonical_json(), "version 2, expected 'arramon-epoch' version 1"),
        (replace(STATEMENT, base="val_seen").canonical_json(), "expected an epoch of 'val_seen'"),
        (replace(STATEMENT, split="test_unseen").canonical_json(), "expected an epoch of 'test_unseen'"),
        (STATEMENT.canonical_json().replace(b"301", b'"many"'), "episodes"),
    ],
)
def test_malformed_statements_are_refused(content: bytes, problem: str) -> None:
    with pytest.raises(BadFile, match=problem):
        read_statement(content, "there")


@pytest.mark.parametrize(
    ("split", "found"),
    [
        ("test_unseen_e1", ("test_unseen", 1)),
        ("a_e1_e12", ("a_e1", 12)),
        ("test_unseen", None),
        ("test_unseen_e0", None),
        ("test_unseen_e01", None),
        ("_e1", None),
        ("test_unseen_e1 ", None),
    ],
)
def test_epochs_are_known_by_their_names(split: str, found: tuple[str, int] | None) -> None:
    assert parse_epoch_name(split) == found
    if found:
        assert (epoch_split_name(*found), epoch_number(split)) == (split, found[1])
    else:
        with pytest.raises(BadInput, match="is not the name of an epoch"):
            epoch_number(split)


@pytest.mark.parametrize("text", ["", SECRET[1:], SECRET.upper(), "g" * 64])
def test_malformed_secrets_are_refused_without_being_repeated(text: str) -> None:
    with pytest.raises(BadInput, match="expected 64 hexadecimal digits") as caught:
        check_secret(text)
    assert not text or text not in str(caught.value)


def test_white_space_around_a_secret_is_ignored() -> None:
    assert check_secret(f" {SECRET}\n") == SECRET
