"""A page of the site that is made from the code."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Page:
    """A generated page.

    Attributes:
        path: its path in the folder of pages, such as "reference/commands/client.md".
        section: its section of the reference in the navigation; empty for a page that is not in the navigation.
        title: its title there.
        text: its Markdown.
    """

    path: str
    section: str
    title: str
    text: str
