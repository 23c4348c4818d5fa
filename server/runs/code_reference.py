"""Validation of the source of an agent's code, which is recorded with a run, signed, and published with it."""

import re

from pydantic import HttpUrl, TypeAdapter, ValidationError

from arramon_server.errors import BadInput, quoted
from arramon_server.runs.storage.records import CodeReference

LONGEST_URL, LONGEST_IMAGE = 300, 300
"""Maximum characters of an address, and of an image with its digest."""

_URL = TypeAdapter(HttpUrl)
_COMMIT = re.compile(r"[0-9a-f]{40}([0-9a-f]{24})?")
_IMAGE = re.compile(r"(?:[a-z0-9][A-Za-z0-9._:/-]*@)?sha256:[0-9a-f]{64}")


def normalize_code(url: str, commit: str, image: str) -> CodeReference:
    """Validate the source of an agent's code, and write the commit in lower case.

    Args:
        url: address of its repository or page, or empty.
        commit: full id of its commit, or empty.
        image: digest of its container image, with or without the image's name, or empty.

    Raises:
        BadInput: if the address is too long, no address of http or https, or has a user's name or password; if the
            commit is no full id, or has no address beside it; or if the image has no digest.
    """
    if url:
        _check_url(url)
    commit = commit.lower()
    if commit and not _COMMIT.fullmatch(commit):
        raise BadInput(f"the code's commit is {quoted(commit)}, expected its full id of 40 or 64 hexadecimal digits")
    if commit and not url:
        raise BadInput("the code has a commit but no address; expected the address of the commit's repository, too")
    if image and (len(image) > LONGEST_IMAGE or not _IMAGE.fullmatch(image)):
        raise BadInput(
            f"the code's image is {quoted(image)}, expected a digest such as 'sha256:...' with 64 hexadecimal digits, "
            f"after 'NAME@' if the image is named, of at most {LONGEST_IMAGE} characters in all"
        )
    return CodeReference(url, commit, image)


def _check_url(url: str) -> None:
    expected = "expected an address such as 'https://example.org/agent' without a user's name or password"
    if len(url) > LONGEST_URL:
        raise BadInput(f"the code's address has {len(url)} characters; at most {LONGEST_URL} are allowed")
    try:
        parsed = _URL.validate_python(url)
    except ValidationError as error:
        raise BadInput(f"the code's address is {quoted(url)}: {expected}") from error
    is_plain = url.isascii() and url.isprintable() and not set(url) & set(' \\"<>`{}|^')
    if not is_plain or parsed.username is not None or parsed.password is not None:
        raise BadInput(f"the code's address is {quoted(url)}: {expected}")
