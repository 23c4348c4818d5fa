"""Watch passes: what a browser keeps instead of a token, to watch its participant's runs on the pages and nothing else.

A pass is made from a token's id, a time of expiry, and their HMAC under the stored hash of the token. So every server
process can check it, it ends with its token, and it cannot be used to play.
"""

import hmac
import time
from hashlib import sha256

from arramon_server.errors import Unauthenticated
from arramon_server.runs.accounts.accounts import find_token, usable_caller
from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.storage.database import Database

PASS_SECONDS = 12 * 3600
"""Time for which a pass is valid."""

LONGEST_PASS = 200
"""Maximum characters of a pass."""

_PURPOSE = b"arramon watch pass "


class WatchPasses:
    """Issues and checks passes. Thread-safe.

    Args:
        database: storage of the tokens.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def issue(self, token: str) -> str:
        """Return a new pass for a token that was authenticated.

        Raises:
            Unauthenticated: if the token has been deleted since.
        """
        token_id = token.split("_")[1]
        row = find_token(self._database, token_id)
        if row is None:
            raise Unauthenticated("authentication failed: unknown token; ask the host for another one")
        expiry = int(time.time()) + PASS_SECONDS
        return f"{token_id}.{expiry}.{_mac(row.hash, token_id, expiry)}"

    def caller(self, watch_pass: str) -> Caller:
        """Return the caller of a pass.

        Raises:
            Unauthenticated: if it is malformed or expired, or its token is not accepted any more.
        """
        token_id, _, rest = watch_pass.partition(".")
        expiry, _, mac = rest.partition(".")
        is_formed = (
            len(watch_pass) <= LONGEST_PASS and watch_pass.isascii() and token_id.isalnum() and expiry.isdecimal()
        )
        row = find_token(self._database, token_id) if is_formed else None
        if row is None or not hmac.compare_digest(mac, _mac(row.hash, token_id, int(expiry))):
            raise Unauthenticated("the watch pass is not valid; sign in again")
        if int(expiry) <= time.time():
            raise Unauthenticated("the watch pass has expired; sign in again")
        return usable_caller(row)


def _mac(token_hash: str, token_id: str, expiry: int) -> str:
    return hmac.new(token_hash.encode(), _PURPOSE + f"{token_id} {expiry}".encode(), sha256).hexdigest()
