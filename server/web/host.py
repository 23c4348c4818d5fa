"""The host of the leaderboard, as shown on its pages."""

from dataclasses import dataclass

from arramon_server.configuration.config import Config

_SCHEMES = ("https://", "http://", "mailto:")
"""Schemes of addresses that the pages link to."""


@dataclass(frozen=True, slots=True)
class Host:
    """The host of the leaderboard, as described in its settings; missing fields are empty.

    Attributes:
        name: the host's name.
        contact: how to reach the host.
        rules: rules of the leaderboard, or the address of a page with them.
    """

    name: str = ""
    contact: str = ""
    rules: str = ""

    @classmethod
    def of(cls, config: Config) -> "Host":
        """Return the host in the settings."""
        return cls(config.host_name, config.host_contact, config.host_rules)

    def __bool__(self) -> bool:
        """Whether any field is set."""
        return bool(self.name or self.contact or self.rules)


UNNAMED = Host()


def link_of(text: str) -> str:
    """Return the link target for a text of the host: a web or mail address; empty if the text is neither."""
    if " " in text:
        return ""
    if text.startswith(_SCHEMES):
        return text
    name, at, domain = text.partition("@")
    return f"mailto:{text}" if name and at and "." in domain and "@" not in domain and ":" not in text else ""
