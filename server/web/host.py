"""Who hosts the leaderboard, as its pages say."""

from dataclasses import dataclass

from arramon_server.configuration.config import Config

_SCHEMES = ("https://", "http://", "mailto:")
"""Beginnings of addresses that the pages link to."""


@dataclass(frozen=True, slots=True)
class Host:
    """Who hosts the leaderboard, in its own words; what it does not say is empty.

    Attributes:
        name: its name.
        contact: how to reach it.
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
        """Whether it says anything."""
        return bool(self.name or self.contact or self.rules)


UNNAMED = Host()


def link_of(text: str) -> str:
    """Return where a page links to with a text of the host's: an address, also for mail; empty if it is none."""
    if " " in text:
        return ""
    if text.startswith(_SCHEMES):
        return text
    name, at, domain = text.partition("@")
    return f"mailto:{text}" if name and at and "." in domain and "@" not in domain and ":" not in text else ""
