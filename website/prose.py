"""The command `python -m website.prose`: finds habits in the English pages that readers had to decode.

It reads the prose of README.md and of `docs/`: paragraphs and lists, without code, tables and Hindi pages. A page may
have as many findings as its budget in `website/prose.toml` allows. Budgets may only fall: `--lower` writes the present
counts where they are smaller. A page that is not in the file has a budget of 0.
"""

import argparse
import re
import sys
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from website.staging import DOCS, FENCE, HINDI, ROOT

BUDGETS = ROOT / "website" / "prose.toml"

LONGEST = 35
"""Words in the longest accepted sentence. A link counts by its text, a piece of code as one word."""

HABITS = {
    "write 'the 95% interval excludes 0' or 'includes 0'": (
        r"intervals? (?:(?:do|does|did) not )?(?:hold|holds|held) (?:0|zero)"
    ),
    "name who does it": r"\b(?:is|are|was|were|be|been) (?:told|spoken of|said|asked for)\b|\b(?:is|are) to be\b",
    "write 'anyone', 'users', 'no one', or name them": r"\b(?:somebody|anybody|everybody|nobody|whoever|whosoever)\b",
    "say what it is": (
        r"\b(?:stands? for|stood for|has come to|have come to|what there is of|of which none|that which)\b"
    ),
    "use today's word": r"\b(?:anew|lest|whence|thereof|therein|thereby|hitherto|whereupon|of late|ere|betimes)\b",
    "use the field's word": (
        r"\b(?:the way walked|bare camera|turned? about|a season of|seasons of|by turns|leads? nowhere)\b"
    ),
    "move history to the changelog": (
        r"\b(?:used to|formerly|previously|until now|since then|changed since)\b"
        r"|\bearlier (?:release|version|run|measurement)s?\b"
    ),
    "write 'to'": r"\bin order to\b",
    "a word is doubled": r"\b(\w+) \1\b",
}
"""Expressions that are found anywhere in a sentence, by what to do instead."""

OPENINGS = {
    "name the subject before the clause": r"(?:What|Whatever|Who|Whom)\b(?!.*\?$)",
    "name who does it, not 'it is done'": (
        r"(?:It|They|This|These) (?:is|are|was|were)"
        r" (?:\w+(?:ed|wn)|made|told|kept|built|left|given|taken|put|set)\b"
    ),
    "begin with a subject": (
        r"(?:Measured|Shown|Told|Asked|Drawn|Kept|Counted|Meant|Played) (?:by|as|on|in|from|with|at|are|is)\b"
    ),
}
"""Expressions at the beginning of a sentence, by what to do instead."""

HEADER = "# Findings of `python -m website.prose` that each page may have; they may only fall."

SENTENCE = re.compile(r"(?<=[.!?])[)\"*']*\s+(?=[\"(*`\[]*[A-Z0-9`])")
BLOCK = re.compile(r"\s*(?:[-*] {1,3}|\d+\. |#+ |> ?|\||!\[|<|!!!|\?\?\?|: |---)")
ITEM = re.compile(r"\s*(?:[-*] +|\d+\. +|> ?)")


@dataclass(frozen=True)
class Finding:
    """A habit in a page.

    Attributes:
        line: number of the line in which its sentence begins, from 1.
        advice: what to do instead.
        text: the words that were found.
    """

    line: int
    advice: str
    text: str


def pages() -> dict[str, Path]:
    """Return the English pages, by their paths in the repository."""
    found = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
    return {path.relative_to(ROOT).as_posix(): path for path in found if not path.is_relative_to(DOCS / HINDI)}


def findings(text: str) -> list[Finding]:
    """Return the habits in a page's prose, in order.

    Args:
        text: the page, in Markdown.
    """
    return [finding for line, block in _blocks(text) for finding in _of_block(line, block)]


def _of_block(line: int, block: str) -> Iterator[Finding]:
    for sentence in SENTENCE.split(_plain(block)):
        words = re.findall(r"[^\W_][\w'%./-]*", sentence)
        if len(words) > LONGEST:
            yield Finding(line, f"{len(words)} words, at most {LONGEST}", " ".join(words[:8]) + " ...")
        for advice, expression in HABITS.items():
            for found in re.finditer(expression, sentence, re.IGNORECASE):
                yield Finding(line, advice, found[0])
        for advice, expression in OPENINGS.items():
            if opening := re.match(expression, sentence.lstrip('*"(')):
                yield Finding(line, advice, opening[0])


def _blocks(text: str) -> Iterator[tuple[int, str]]:
    """Yield paragraphs and items of lists with the numbers of their first lines."""
    fenced, begun = False, 0
    block: list[str] = []
    for number, line in enumerate([*text.split("\n"), ""], 1):
        fence = FENCE.match(line) is not None
        ends = fenced or fence or not line.strip() or BLOCK.match(line) is not None
        fenced ^= fence
        if ends and block:
            yield begun, " ".join(block)
            block = []
        if fenced or fence or not line.strip() or (BLOCK.match(line) and not ITEM.match(line)):
            continue
        if not block:
            begun = number
        block.append(ITEM.sub("", line, count=1).strip() if ends else line.strip())


def _plain(block: str) -> str:
    """Return a block without what is not read as words: code, addresses of links, formatting."""
    block = re.sub(r"`[^`]*`", "`x`", block)
    block = re.sub(r"!?\[((?:[^\[\]]|\[[^\]]*\])*)\]\([^)]*\)(?:\{[^}]*\})?", r"\1", block)
    return block.replace("**", "")


def budgets() -> dict[str, int]:
    """Return the most findings that each page may have."""
    allowed: dict[str, int] = tomllib.loads(BUDGETS.read_text(encoding="utf-8"))["budget"]
    return allowed


def lowered(allowed: dict[str, int], counts: dict[str, int]) -> str:
    """Return the content of the file of budgets with the smaller of each page's budget and count.

    Args:
        allowed: the present budgets.
        counts: findings of all pages.
    """
    kept = {page: min(count, allowed.get(page, 0)) for page, count in counts.items()}
    lines = [f'"{page}" = {count}' for page, count in sorted(kept.items()) if count]
    return "\n".join([HEADER, "[budget]", *lines, ""])


def main(arguments: Sequence[str] | None = None) -> int:
    """Print findings, and return the exit status: 1 if a page has more than its budget."""
    parser = argparse.ArgumentParser(prog="python -m website.prose", description=__doc__)
    parser.add_argument("pages", nargs="*", help="pages to print, such as docs/index.md; all by default")
    parser.add_argument("--counts", action="store_true", help="print the number of each page instead")
    parser.add_argument("--lower", action="store_true", help="lower the budgets to the present counts")
    given = parser.parse_args(arguments)
    found = {page: findings(path.read_text(encoding="utf-8")) for page, path in pages().items()}
    if unknown := set(given.pages) - found.keys():
        parser.error(f"no such page: {', '.join(sorted(unknown))}")
    allowed = budgets()
    for page in given.pages or found:
        if given.counts:
            sys.stdout.write(f"{len(found[page]):5} of {allowed.get(page, 0):3}  {page}\n")
            continue
        for each in found[page]:
            sys.stdout.write(f"{page}:{each.line}: {each.advice}: {each.text}\n")
    counts = {page: len(each) for page, each in found.items()}
    sys.stdout.write(f"{sum(counts.values())} findings in {len(counts)} pages\n")
    if given.lower:
        BUDGETS.write_text(lowered(allowed, counts), encoding="utf-8")
    return int(any(count > allowed.get(page, 0) for page, count in counts.items()))


if __name__ == "__main__":
    sys.exit(main())
