"""Settings that the scripts of the verify page and of the placement test read."""

from collections.abc import Sequence
from typing import Any

from arramon_collecting.web.access import CSRF_HEADER, Visitor
from arramon_server.web.page_texts import PageTexts

GROUPS = ("play_js", "collect_verify_js")
"""Groups of texts that the scripts use; the later one's texts replace those of the earlier one."""


def play_settings(t: PageTexts, visitor: Visitor, *, socket: str, player: str, sizes: Sequence[int]) -> dict[str, Any]:
    """Return the settings that both pages share.

    Args:
        t: texts of the page's language.
        visitor: who asks.
        socket: address of the WebSocket.
        player: the stream's player: the same in all of the worker's tabs, so that the latest one plays.
        sizes: the largest and the smallest side length of the images, in pixels.
    """
    texts = {
        key.partition(".")[2]: text for group in GROUPS for key, text in t.words.items() if key.startswith(f"{group}.")
    }
    return {
        "socket": socket,
        "player": player,
        "language": t.language,
        "sizes": list(sizes),
        "texts": texts,
        "csrf": visitor.csrf,
        "csrfHeader": CSRF_HEADER,
    }
