"""The linter of prose: what it finds, what it leaves, and the budgets of the pages."""

import pytest

from website import prose


def words(number: int) -> str:
    return " ".join(f"word{each}" for each in range(number))


LONG = words(36)

FOUND = [
    (f"It fits. {LONG.capitalize()}.", "36 words, at most 35"),
    ("All intervals hold 0.", "write 'the 95% interval excludes 0' or 'includes 0'"),
    ("The agent is told its target.", "name who does it"),
    ("- A run that\n  nobody started", "write 'anyone', 'users', 'no one', or name them"),
    ("A seed stands for a draw.", "say what it is"),
    ("The frame is drawn anew.", "use today's word"),
    ("Compare it with the bare camera.", "use the field's word"),
    ("An earlier release signed scores.", "move history to the changelog"),
    ("Run it in order to see.", "write 'to'"),
    ("See the the page.", "a word is doubled"),
    ("What a client has sent stays.", "name the subject before the clause"),
    ("The page loads. It is drawn twice.", "name who does it, not 'it is done'"),
    ("Measured by a command.", "begin with a subject"),
]

LEFT = [
    f"{words(35)}.",
    "The 95% interval excludes 0.",
    f"```sh\nnobody # {LONG}\n```",
    f"| nobody | {LONG} |",
    "`nobody anew`",
    "[The page](nobody-anew.md)",
    "What is a turn?",
    f"{words(30)}: [{words(5)}](a-long-address.md).",
]


@pytest.mark.parametrize(("text", "advice"), FOUND)
def test_it_finds(text: str, advice: str) -> None:
    assert [each.advice for each in prose.findings(f"# Title\n\n{text}\n")] == [advice]


@pytest.mark.parametrize("text", LEFT)
def test_it_leaves(text: str) -> None:
    assert prose.findings(f"# Title\n\n{text}\n") == []


def test_it_names_the_line_and_the_words() -> None:
    (found,) = prose.findings("# Title\n\nA paragraph.\n\n1. An item,\n   as nobody reads it.\n")
    assert (found.line, found.text) == (5, "nobody")


def test_budgets_only_fall() -> None:
    lines = prose.lowered({"a.md": 3, "b.md": 1, "gone.md": 5}, {"a.md": 2, "b.md": 4, "c.md": 1}).splitlines()
    assert lines[1:] == ["[budget]", '"a.md" = 2', '"b.md" = 1']


@pytest.mark.parametrize("page", prose.pages())
def test_a_page_keeps_its_budget(page: str) -> None:
    found = prose.findings(prose.pages()[page].read_text(encoding="utf-8"))
    allowed = prose.budgets().get(page, 0)
    assert len(found) <= allowed, "\n".join(f"{page}:{each.line}: {each.advice}: {each.text}" for each in found)


def test_budgets_are_of_pages_that_exist() -> None:
    assert set(prose.budgets()) <= set(prose.pages())
