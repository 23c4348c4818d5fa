"""Template variables of the page about people, as a group beside the paper's people."""

from collections.abc import Mapping
from typing import Any

from arramon_server.board.board import Board
from arramon_server.board.people import PeopleBoard
from arramon_server.board.standings import COLUMNS, TOTAL
from arramon_server.errors import NotFound
from arramon_server.web.page_texts import PageTexts


class PeoplePage:
    """Builds the variables of the page.

    Args:
        board: the leaderboard.
        people: groups of people.
    """

    def __init__(self, board: Board, people: PeopleBoard) -> None:
        self._board = board
        self._people = people

    def context(self, t: PageTexts, query: Mapping[str, str]) -> dict[str, Any]:
        """Return the variables of the template.

        Args:
            t: texts of the page's language.
            query: query of the address: "split" and "language", of the instructions.

        Raises:
            NotFound: if there is no such split or language.
        """
        known = self._board.languages()
        pairs = [(split, code) for split, codes in known.items() for code in codes]
        if not pairs:
            raise NotFound("this server has no splits")
        default = next((pair for pair in pairs if self._people.groups(*pair)), None)
        default = default or next((pair for pair in pairs if pair[1] == t.language), pairs[0])
        split = query.get("split", default[0])
        language = query.get("language", default[1] if split == default[0] else t.language)
        if (split, language) not in pairs:
            raise NotFound("there is no such split or language")
        return {
            "split": split,
            "language": language,
            "splits": [(name, name) for name in known],
            "languages_choices": [(code, t.named("languages", code)) for code in sorted({code for _, code in pairs})],
            "columns": list(COLUMNS.values()),
            "metrics": list(COLUMNS),
            "groups": self._people.groups(split, language),
            "references": [(one, one.rows[TOTAL]) for one in self._people.references(split, language)],
        }
