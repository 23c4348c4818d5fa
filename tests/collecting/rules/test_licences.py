"""Addresses of licences: those of Creative Commons are known, in the language of the page."""

import pytest

from arramon_collecting.rules.licences import licence_address


@pytest.mark.parametrize(
    ("licence", "language", "address"),
    [
        ("CC-BY-4.0", "hi", "https://creativecommons.org/licenses/by/4.0/deed.hi"),
        ("CC-BY-NC-SA-3.0", "en", "https://creativecommons.org/licenses/by-nc-sa/3.0/deed.en"),
        ("CC0-1.0", "en", "https://creativecommons.org/publicdomain/zero/1.0/deed.en"),
        ("MIT", "en", ""),
        ("CC-BY-4.0 or later", "en", ""),
        ("our own", "en", ""),
    ],
)
def test_addresses(licence: str, language: str, address: str) -> None:
    assert licence_address(licence, language) == address
