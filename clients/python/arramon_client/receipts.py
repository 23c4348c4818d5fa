"""Receipts on the participant's side: kept in a file, read back, and checked against the host's key and own actions."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
from cryptography.hazmat.primitives.serialization import load_pem_public_key

from arramon.v1 import evaluation_pb2
from arramon.v1.chain import episode_head, run_digest
from arramon_client.errors import ReceiptError
from arramon_client.files import write_whole

FILE_FORMAT, FILE_VERSION = "arramon-receipt-file", 1
FORMAT, VERSION = "arramon-receipt", 1

SUFFIX = ".receipt.json"
"""Of a receipt's file, which lies beside the results' file of its run."""

KEY_BYTES, SIGNATURE_BYTES = 32, 64


NUMBER, EVERY = (int, float), "*"

SHAPE = {
    "run": {
        **dict.fromkeys(("run_id", "participant", "agent", "split", "language", "state", "created_at"), str),
        "ended_at": (str, type(None)),
    },
    "limits": dict.fromkeys(("steps_per_phase", "step_seconds", "first_step_seconds", "bank_seconds"), NUMBER),
    "data_hash": str,
    "score_signature": str,
    "causes": {EVERY: int},
    "reoffers": int,
    "steps": int,
    "scores": {EVERY: {EVERY: dict.fromkeys(("mean", "low", "high"), NUMBER)}},
    "episodes": [{"episode_id": str, "cause": str, "steps": int, "head": str}],
    "digest": str,
}
"""What a receipt's content has at least: anybody can sign anything."""


@dataclass(frozen=True)
class Receipt:
    """A receipt whose signature is right, by the key that it names itself.

    Attributes:
        public_key: 32 bytes; to be trusted only if it is the host's.
        content: what was signed, as plain data; `docs/receipts.md` describes it.
    """

    public_key: bytes
    content: Mapping[str, Any]

    @property
    def run(self) -> Mapping[str, Any]:
        """The run, and what it was played under."""
        run: Mapping[str, Any] = self.content["run"]
        return run

    @property
    def episodes(self) -> Sequence[Mapping[str, Any]]:
        """The run's episodes, in playing order."""
        episodes: Sequence[Mapping[str, Any]] = self.content["episodes"]
        return episodes


def write_receipt(receipt: evaluation_pb2.Receipt, run_id: str, folder: Path) -> Path:
    """Writes `<folder>/<run id>.receipt.json`, whole or not at all.

    Returns:
        The file.

    Raises:
        OutputError: if it cannot be written.
    """
    content = {
        "format": FILE_FORMAT,
        "version": FILE_VERSION,
        "payload": receipt.payload.decode(),
        "signature": receipt.signature.hex(),
        "public_key": receipt.public_key.hex(),
    }
    path = folder / f"{run_id}{SUFFIX}"
    write_whole(path, json.dumps(content, indent=2, ensure_ascii=False) + "\n")
    return path


def read_json(path: Path, kind: str) -> Any:
    """What a file holds that is to be a "receipt", or of another such kind.

    Raises:
        ReceiptError: if it cannot be read, or is not JSON.
    """
    try:
        return json.loads(path.read_bytes())
    except OSError as error:
        raise ReceiptError(f"{path} cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise ReceiptError(f"{path} is no {kind}: it is not JSON, or was cut") from error


def read_receipt(path: Path) -> Receipt:
    """A receipt from its file.

    Raises:
        ReceiptError: if it cannot be read, or was not signed as it stands.
    """
    content = read_json(path, "receipt")
    _check_format(path, content, FILE_FORMAT, FILE_VERSION)
    payload = content.get("payload")
    if not isinstance(payload, str):
        raise ReceiptError(f"{path} is no receipt: it has no payload")
    signature = _bytes(path, content, "signature", SIGNATURE_BYTES)
    key = _bytes(path, content, "public_key", KEY_BYTES)
    return _checked(path, payload, signature, key)


def read_key(text: str) -> bytes:
    """A host's public key, 32 bytes.

    Args:
        text: the key in hexadecimal, or a file that holds it so, or as PEM.

    Raises:
        ReceiptError: if it is none of these.
    """
    content = text
    if not _is_hexadecimal(text):
        try:
            content = Path(text).read_text().strip()
        except (OSError, UnicodeDecodeError) as error:
            raise ReceiptError(f"{text} is no key in hexadecimal, and no file that can be read: {error}") from error
    if _is_hexadecimal(content):
        return bytes.fromhex(content)
    try:
        key = load_pem_public_key(content.encode())
    except ValueError:
        key = None
    if not isinstance(key, Ed25519PublicKey):
        raise ReceiptError(
            f"{text} holds no public key: expected {2 * KEY_BYTES} hexadecimal digits, or Ed25519 in PEM"
        )
    return key.public_bytes_raw()


def check_key(receipt: Receipt, key: bytes, whose: str) -> None:
    """Makes sure that a receipt was signed with a key.

    Args:
        key: 32 bytes.
        whose: it is, in words.

    Raises:
        ReceiptError: if it was another.
    """
    if receipt.public_key != key:
        raise ReceiptError(
            f"the receipt is signed with the key {receipt.public_key.hex()}, not with {whose}, {key.hex()}. "
            "A host that has changed its key can tell which it had before"
        )


def check_actions(receipt: Receipt, actions: Mapping[str, Sequence[int]]) -> int:
    """Makes sure that a receipt is about the very actions that a client sent; returns in how many episodes it is.

    Args:
        actions: by episode, from its first step on; what was sent behind its end is no matter.

    Raises:
        ReceiptError: if it is about others.
    """
    checked = 0
    for episode in receipt.episodes:
        sent, steps = actions.get(episode["episode_id"]), episode["steps"]
        if sent is None:
            continue
        if len(sent) < steps:
            raise ReceiptError(
                f"episode {episode['episode_id']}: the receipt has {steps} steps, and this client sent {len(sent)}"
            )
        head = episode_head(receipt.run["run_id"], episode["episode_id"], receipt.content["data_hash"], sent[:steps])
        if head.hex() != episode["head"]:
            raise ReceiptError(
                f"episode {episode['episode_id']}: the receipt is about other actions than this client sent"
            )
        checked += 1
    return checked


def _checked(path: Path, payload: str, signature: bytes, key: bytes) -> Receipt:
    try:
        Ed25519PublicKey.from_public_bytes(key).verify(signature, payload.encode())
    except (InvalidSignature, ValueError) as error:  # the latter for what UTF-8 cannot hold
        raise ReceiptError(f"{path} was altered: its signature is not over these bytes, or not by this key") from error
    try:
        content = json.loads(payload)
    except (ValueError, RecursionError):
        content = None
    _check_format(path, content, FORMAT, VERSION)
    if not _fits(SHAPE, content):
        raise ReceiptError(f"{path} is signed, but does not hold what a receipt holds")
    receipt = Receipt(key, content)
    heads = [(episode["episode_id"], _bytes(path, episode, "head", 32)) for episode in receipt.episodes]
    if run_digest(receipt.run["run_id"], heads).hex() != content["digest"]:
        raise ReceiptError(f"{path} contradicts itself: its digest is not that of its episodes")
    return receipt


def _check_format(path: Path, content: Any, name: str, version: int) -> None:
    if not isinstance(content, dict) or content.get("format") != name:
        raise ReceiptError(f"{path} is no receipt: it has no format {name!r}")
    if content.get("version") != version:
        raise ReceiptError(f"{path} has the {name} version {content.get('version')!r}, and this client reads {version}")


def _fits(shape: Any, value: Any) -> bool:
    if isinstance(shape, list):
        return isinstance(value, list) and all(_fits(shape[0], each) for each in value)
    if not isinstance(shape, dict):
        return isinstance(value, shape)
    if not isinstance(value, dict):
        return False
    if EVERY in shape:
        return all(_fits(shape[EVERY], each) for each in value.values())
    return all(_fits(each, value.get(name)) for name, each in shape.items())


def _bytes(path: Path, content: Mapping[str, Any], name: str, length: int) -> bytes:
    text = content.get(name)
    try:
        found = bytes.fromhex(text) if isinstance(text, str) else b""
    except ValueError:
        found = b""
    if len(found) != length:
        raise ReceiptError(f"{path} is no receipt: its {name} is not {length} bytes in hexadecimal")
    return found


def _is_hexadecimal(text: str) -> bool:
    return len(text) == 2 * KEY_BYTES and set(text.lower()) <= set("0123456789abcdef")
