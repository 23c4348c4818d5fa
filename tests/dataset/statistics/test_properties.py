"""Linguistic properties: the paper's examples, Hindi equivalents, and malformed files."""

import json
import re
from pathlib import Path

import pytest

from arramon_dataset.statistics.properties import PROPERTIES, load_patterns
from arramon_dataset.statistics.words import words_of
from arramon_lang import available, load
from arramon_server.errors import BadFile
from tests.release import VAL_SEEN, needs_release


@pytest.mark.parametrize(
    ("code", "text", "properties"),
    [
        # The paper's examples, each with the property it stands for.
        ("en", "Go straight so the striped green bucket with the red tv on top of it is to your right.", "egocentric"),
        ("en", "Place the dotted yellow bucket on the left side of the striped brown bowl.", "allocentric"),
        ("en", "Continue to walk forward until you reach an intersection.", "temporal directional"),
        ("en", "Make a slight left and walk forward stopping at the intersection.", "directional"),
        ("en", "Go forward past the dotted yellow bucket and past the lamp post near the blue booth.", "sequencing"),
        ("en", "Put the striped blue book behind the dotted red mug.", "discrete_3d allocentric"),
        ("hi", "बेंच आपके बाईं ओर है।", "egocentric"),
        ("hi", "गेंद को धारीदार भूरी किताब के बाईं ओर रख दीजिए।", "allocentric"),
        ("hi", "जब तक दो लैंप पोस्ट न दिखें, चलते रहें।", "temporal"),
        ("hi", "थोड़ा दाएँ मुड़ें।", "directional"),
        ("hi", "नुक्कड़ तक चलें, फिर रुकें।", "sequencing"),
        ("hi", "मग को बिंदीदार हरे टीवी के पीछे रखें।", "discrete_3d allocentric"),
    ],
)
def test_expected_properties_are_found(code: str, text: str, properties: str) -> None:
    assert load_patterns(code).find(words_of(load(code), text)) >= set(properties.split())


@pytest.mark.parametrize(
    ("code", "text", "properties"),
    [
        ("en", "Pick up the mug.", ""),
        ("en", "Place it in front of you.", "egocentric"),
        ("en", "Turn left before you reach the cone.", "temporal directional"),
        ("en", "Place the red book to the left of the blue mug.", "allocentric"),
        ("en", "Pick up the leftover backpack.", ""),  # Whole words only.
        ("hi", "मग उठाएँ।", ""),
        ("hi", "मग को टीवी के दाईं ओर रखें।", "allocentric"),
        ("hi", "मग को दीवार से सटाकर रखें।", "allocentric"),
    ],
)
def test_no_other_properties_are_found(code: str, text: str, properties: str) -> None:
    assert load_patterns(code).find(words_of(load(code), text)) == set(properties.split())


@pytest.mark.parametrize("code", available())
def test_every_language_has_patterns_for_all_properties(code: str) -> None:
    patterns = load_patterns(code)
    assert tuple(patterns.properties) == PROPERTIES
    assert patterns.stopwords


GOOD = 'stopwords = ["the"]\n[parts]\n[properties]\n' + "\n".join(f'{name} = ["x"]' for name in PROPERTIES)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("stopwords = ", "is not TOML"),
        ("stopwords = []", "parts: is not a table of strings"),
        (GOOD.replace('["the"]', '"the"'), "stopwords: is not a list of words"),
        (GOOD.replace("temporal", "other"), "properties: has egocentric, allocentric, other,"),
        (GOOD.replace('temporal = ["x"]', 'temporal = ["x("]'), "properties.temporal: is not a list of regular"),
        (GOOD.replace('temporal = ["x"]', 'temporal = ["{side}"]'), "properties.temporal: has an unknown part {side}"),
        (GOOD.replace('temporal = ["x"]', "temporal = [1]"), "properties.temporal: is not a list of regular"),
    ],
)
def test_malformed_property_files_are_refused(tmp_path: Path, content: str, message: str) -> None:
    file = tmp_path / "xx" / "properties.toml"
    file.parent.mkdir()
    file.write_text(content)
    with pytest.raises(BadFile, match=re.escape(message)):
        load_patterns("xx", tmp_path)


def test_missing_property_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(BadFile, match=re.escape("xx/properties.toml: cannot be read")):
        load_patterns("xx", tmp_path)


@needs_release
@pytest.mark.parametrize(
    ("phase", "shares"),
    [("navi_inst_gt", (34, 86, 64, 96, 66, 72)), ("assem_inst_gt", (34, 98, 2, 68, 58, 34))],
)
def test_property_shares_of_the_release_are_near_the_papers(phase: str, shares: tuple[int, ...]) -> None:
    """Per episode, as in the paper, whose fifty were read by people: near, but for sequencing."""
    patterns, english = load_patterns("en"), load("en")
    records = json.loads(VAL_SEEN.read_text())
    found = [
        frozenset().union(*(patterns.find(words_of(english, text)) for text in record["instructions"][phase]))
        for record in records
    ]
    for name, share in zip(PROPERTIES, shares, strict=True):
        percent = 100 * sum(name in each for each in found) / len(found)
        assert percent == pytest.approx(share, abs=32 if name == "sequencing" else 12), name
