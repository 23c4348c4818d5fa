"""Masks passwords and tokens in everything that is printed or logged."""

import re
from urllib.parse import unquote

MASK = "***"
"""Shown instead of a secret."""

_SECRET_KEY = re.compile(
    r"[\w.-]*(?:passw(?:or)?d|passphrase|pwd|client_secret|scram_(?:client|server)_key)\w*|pass", re.IGNORECASE
)
"""Names of values that are secret: libpq's `password` and `sslpassword`, `PGPASSWORD`, `db.passwd`, and the like."""

_SAFE_OPTIONS = frozenset({
    "application_name", "cache", "channel_binding", "client_encoding", "connect_timeout", "dbname",
    "fallback_application_name", "gssdelegation", "gssencmode", "gsslib", "host", "hostaddr", "keepalives",
    "keepalives_count", "keepalives_idle", "keepalives_interval", "krbsrvname", "load_balance_hosts",
    "max_protocol_version", "min_protocol_version", "mode", "options", "passfile", "port", "replication",
    "require_auth", "requirepeer", "requiressl", "service", "ssl_max_protocol_version",
    "ssl_min_protocol_version", "sslcert", "sslcertmode", "sslcompression", "sslcrl", "sslcrldir", "sslkey",
    "sslmode", "sslnegotiation", "sslrootcert", "sslsni", "target_session_attrs", "tcp_user_timeout", "timeout",
    "uri", "user",
})  # fmt: skip
"""Options of a database URL that are no secrets; `mask_url` masks the values of all others."""

_VALUE = r"""(?:'(?:[^'\\]|\\.|'')*'|"(?:[^"\\]|\\.)*"|(?:\\.|[^\s\\])+)"""
"""A quoted value, or a value up to the next unescaped space. In case of doubt it matches too much."""

_TOKENS = (
    (re.compile(r"\b(arramon_[0-9A-Za-z]+_)[0-9A-Za-z_-]+"), rf"\1{MASK}"),
    (re.compile(r"\b(bearer\s+)(?!arramon_)[^\s\"',]+", re.IGNORECASE), rf"\1{MASK}"),
)
"""Patterns of participants' tokens and of other bearer tokens, each with its replacement."""

# The password of a URL: up to the first @, and on to the last @ before the path.
_USER_INFO = re.compile(r"(://[^:/@\s]*:)[^@\s]*@(?:[^/?\s]*@)?")
_WHOLE_URL_USER_INFO = re.compile(r"^([^:/]*://[^:/@]*:)[^@]*@(?:[^/?]*@)?")
_OPTION = re.compile(r"(?<=[?&;])([\w%.+-]+)=([^&\s]*)")
_PAIR = re.compile(rf"(?<![\w%.?&;-])({_SECRET_KEY.pattern})(\s*=\s*){_VALUE}", re.IGNORECASE)
_QUOTED_PAIR = re.compile(rf"""(["'](?:{_SECRET_KEY.pattern})["']\s*[:,=]\s*){_VALUE}""", re.IGNORECASE)


def mask_secrets(text: str) -> str:
    """Return a text with passwords and tokens masked.

    It masks tokens, and passwords in the user part and the options of URLs (also if option names are percent-encoded),
    in `key=value` settings such as libpq's and environment variables, and in the text of a dict or JSON object.
    """
    text = _USER_INFO.sub(rf"\1{MASK}@", text)
    text = _OPTION.sub(_masked_option, text)
    text = _PAIR.sub(rf"\1\2{MASK}", text)
    text = _QUOTED_PAIR.sub(rf"\1{MASK!r}", text)
    for pattern, instead in _TOKENS:
        text = pattern.sub(instead, text)
    return text


def is_secret(name: str) -> bool:
    """Return whether a value with this name is secret, such as `password`."""
    return _SECRET_KEY.fullmatch(name) is not None


def mask_url(url: str) -> str:
    """Return a database URL with its password masked, and the values of all options that are not known to be safe."""
    url = _WHOLE_URL_USER_INFO.sub(rf"\1{MASK}@", url)  # here a password may have spaces
    place, mark, options = url.partition("?")
    return mask_secrets(place + mark + "&".join(map(_masked_part, options.split("&"))))


def _masked_option(found: re.Match[str]) -> str:
    return f"{found[1]}={MASK}" if is_secret(unquote(found[1])) else found[0]


def _masked_part(option: str) -> str:
    name, given, _ = option.partition("=")
    return f"{name}={MASK}" if given and unquote(name).strip().lower() not in _SAFE_OPTIONS else option
