"""Mentions of collectibles in texts."""

import pytest

from arramon_lang import load

OutlineEntry = tuple[str | None, str | None, str | None]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Pick up the striped red mug.", [("striped", "red", "mug")]),
        ("green striped bucket", [("striped", "green", "bucket")]),
        ("Striped Green Tv", [("striped", "green", "tv")]),
        ("the ball", [(None, None, "ball")]),
        ("a purple television set", [(None, "purple", "tv")]),
        ("the spotted violet hour glass", [("dotted", "purple", "hourglass")]),
        ("polka-dot blue cups", [("dotted", "blue", "mug")]),
        ("the dotted, green ball", [("dotted", "green", "ball")]),
        ("the orange/brown dotted hourglass", [("dotted", "brown", "hourglass")]),
        ("the striped orange bowl", [("striped", None, "bowl")]),
        # One letter wrong in a word of five or more.
        ("dtriped brown book", [("striped", "brown", "book")]),
        ("dooted whtie Horuglass", [("dotted", "white", "hourglass")]),
        ("the stiped purpe buckt", [("striped", "purple", "bucket")]),
        # In a shorter one it may be another word; and some words are near one and mean what they say.
        ("the back of the box", []),
        ("while you write on the walls", []),
        # A pattern behind its noun, unless it belongs to the next.
        ("the yellow ball with black stripes.", [("striped", "yellow", "ball")]),
        ("the bucket with the striped red bowl", [(None, None, "bucket"), ("striped", "red", "bowl")]),
        ("the green tv with striped red bowl", [(None, "green", "tv"), ("striped", "red", "bowl")]),
        # A kind that is not said.
        ("the dotted red one", [("dotted", "red", None)]),
        ("the dotted one", [("dotted", None, None)]),
        ("collect the dotted brown in front of it", [("dotted", "brown", None)]),
        ("the striped blue, then go", [("striped", "blue", None)]),
        # What is no collectible.
        ("the striped wall, the red banner, the spotted brick wall", []),
        ("a green trash can", []),
        ("the green striped trash can", [("striped", "green", "bucket")]),
        ("you can see the blue phone booth", []),
        ("", []),
        # Several.
        ("the book on the mug", [(None, None, "book"), (None, None, "mug")]),
        ("striped red dotted white mug", [("striped", "red", None), ("dotted", "white", "mug")]),
    ],
)
def test_english_mentions_are_found(text: str, expected: list[OutlineEntry]) -> None:
    assert [(m.pattern, m.colour, m.kind) for m in load("en").find_objects(text)] == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # Direct, oblique and feminine forms.
        ("नीला कटोरा उठाएँ।", [(None, "blue", "bowl")]),
        ("नीले कटोरे को उठाएँ।", [(None, "blue", "bowl")]),
        ("बेंच के पास रखा धारीदार लाल मग उठा लें।", [("striped", "red", "mug")]),
        ("बिंदीदार नीली गेंद", [("dotted", "blue", "ball")]),
        ("बिंदीदार सफ़ेद रेतघड़ी ले लीजिए।", [("dotted", "white", "hourglass")]),
        ("एक धारीदार बैंगनी टीवी है", [("striped", "purple", "tv")]),
        ("हरे टीवी के पीछे", [(None, "green", "tv")]),
        ("पीली बाल्टियाँ, भूरी किताबों", [(None, "yellow", "bucket"), (None, "brown", "book")]),
        # Other spellings, and the order turned round.
        ("सफेद धारियों वाली टी.वी.", [("striped", "white", "tv")]),
        ("लाल बिन्दीदार रेत घड़ी", [("dotted", "red", "hourglass")]),
        ("सफ\u093cेद और धब्बेदार TV", [("dotted", None, "tv")]),
        ("सफ\u093cेद रेतघ\u095cी", [(None, "white", "hourglass")]),
        # One letter wrong.
        ("धारीददार किताव", [("striped", None, "book")]),
        ("बिंदीदार वाली उठाओ", [("dotted", None, None)]),
        # What is no collectible.
        ("धब्बेदार दीवार के सामने, लाल बैनर की ओर", []),
        ("भूरी इमारत के पास से बाएँ मुड़ें।", []),
    ],
)
def test_hindi_mentions_are_found(text: str, expected: list[OutlineEntry]) -> None:
    assert [(m.pattern, m.colour, m.kind) for m in load("hi").find_objects(text)] == expected


@pytest.mark.parametrize(
    ("code", "text", "expected"),
    [
        ("en", "Place the  Dotted, Red  Mug on the striped one.", ["Dotted, Red  Mug", "striped one"]),
        ("en", "The ball with dots", ["ball with dots"]),
        ("en", "striped blue, then", ["striped blue"]),
        ("hi", "मग को बिंदीदार हरे टीवी के पीछे रखें।", ["मग", "बिंदीदार हरे टीवी"]),
        # Their places are those in the text as it was given, whatever normalising makes of it.
        ("hi", "रेतघ\u095cी को लाल\u200c मग पर", ["रेतघ\u095cी", "लाल\u200c मग"]),
    ],
)
def test_mentions_have_their_position_in_the_text(code: str, text: str, expected: list[str]) -> None:
    assert [text[m.start : m.end] for m in load(code).find_objects(text)] == expected
