"""Exact names of kinds of things: guesses of the readers of texts are none."""

import pytest

from arramon_collecting.writing.exact_names import names_exactly


@pytest.mark.parametrize(
    ("text", "kind", "language", "is_named"),
    [
        ("Walk past the orange Cones on your left.", "cone", "en", True),
        ("Walk past the traffic cone.", "cone", "en", True),
        ("Walk past the traffic cone.", "traffic_light", "en", False),
        ("Walk past the ice-cream kone.", "cone", "en", False),
        ("Turn right at the blue bank.", "banner", "en", False),
        ("फ़ोन बूथ के पास से चलें।", "phone_booth", "hi", True),
        ("नीले बैंक पर दाएँ मुड़ें।", "banner", "hi", False),
        ("गति-सीमा का बोर्ड पार करें।", "barrier", "hi", False),
    ],
)
def test_names(text: str, kind: str, language: str, is_named: bool) -> None:
    assert names_exactly(text, kind, language) is is_named
