"""Hindi in Latin letters, Hinglish, English words in Devanagari, and texts whose clauses are of two languages."""

import pytest

import arramon_lang as lang
from arramon_lang.meaning import Assembly, Navigation, Rotate, Walk

HINDI = lang.load("hi")

PLAIN = "दाएँ मुड़ो। लाल कोन तक सीधे जाओ और चौराहे पर बाएँ मुड़ो। पेड़ के पास रखी बिंदीदार नीली गेंद उठा लो।"

SAME = {
    "romanised": "dayein mudo. laal cone tak seedhe jao aur chaurahe par bayein mudo. "
    "ped ke paas rakhi bindidar neeli gend utha lo",
    "romanised, other spellings": "daye muro lal cone tk sidhe jao or choraahe pe baaye muro. "
    "per k pass rakhi bindeedaar nili gaind uthaa lo",
    "nouns": "dayen mudo. red cone tak seedhe jao aur intersection pe bayen mudo. "
    "tree ke paas rakhi dotted blue ball utha lo",
    "nouns and verbs": "right turn lo, red cone tak straight jao aur intersection pe left le lo. "
    "tree ke paas rakhi dotted blue ball pick kar lo",
    "loans": "राइट टर्न लो। रेड कोन तक स्ट्रेट जाओ और इंटरसेक्शन पर लेफ़्ट ले लो। ट्री के पास रखी डॉटेड ब्लू बॉल पिक कर लो।",
    "clauses": "dayein mudo. laal cone tak seedhe jao. Turn left at the intersection. "
    "ped ke paas rakhi dotted blue ball utha lo",
}


def route(meaning: object) -> tuple[object, ...]:
    """Return the parts of a navigation that a wording must keep."""
    assert isinstance(meaning, Navigation)
    steps = [
        (step.direction, step.at, step.thing and step.thing.kind) if isinstance(step, Rotate)
        else (step.way, [thing.kind for thing in step.things]) if isinstance(step, Walk) else step
        for step in meaning.steps
    ]  # fmt: skip
    target = meaning.target
    where = [(each.relation, each.things[0].kind) for each in target.where]
    return (steps, target.kind, target.colour, target.look, where)


@pytest.mark.parametrize("form", SAME)
def test_a_text_means_the_same_in_every_form(form: str) -> None:
    assert route(HINDI.read(SAME[form], "navigation")) == route(HINDI.read(PLAIN, "navigation"))


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("gend ko red mug ke upar rakh do", "गेंद को लाल मग के ऊपर रख दो।"),
        ("striped green wala mug blue bucket ke front me place karo", "धारीदार हरा मग नीली बाल्टी के सामने रखो।"),
        ("dots wali kitab ko brick wall se sata ke rakhna", "बिंदीदार किताब को ईंट की दीवार से सटाकर रखना।"),
        ("laal mug or pili kitaab k beech m rakho", "लाल मग और पीली किताब के बीच में रखो।"),
        ("Put the ball on top of the red mug, baayi deewar ke paas.", "गेंद को लाल मग के ऊपर, बाईं दीवार के पास रखो।"),
    ],
)
def test_placements(text: str, plain: str) -> None:
    read, meant = HINDI.read(text, "assembly"), HINDI.read(plain, "assembly")
    assert isinstance(read, Assembly)
    assert isinstance(meant, Assembly)
    assert (read.thing.kind, read.where) == (meant.thing.kind, meant.where)


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("par karo", "पार करो"),
        ("bench par", "bench पर"),
        ("ped ki or", "पेड़ की ओर"),
        ("mug or gend", "mug और गेंद"),
        ("left me", "बाएँ में"),
        ("ke pass", "के पास"),
        ("ret ghadi", "रेत घड़ी"),
        ("neeli gadi", "नीली गाड़ी"),
        ("jb tk", "जब तक"),
        ("triangle wala blue banner", "triangle blue banner"),
        ("mein qwrtz", "में qwrtz"),
    ],
)
def test_context_decides_between_words_that_sound_alike(words: str, meant: str) -> None:
    reader = HINDI.second_script
    assert reader is not None
    assert reader.transcribe(words) == HINDI.normalise(meant)


def test_things_of_two_languages_have_different_identities() -> None:
    meaning = HINDI.read("Turn left at the red cone. peele drum ke paas rakhi gend utha lo.", "navigation")
    assert isinstance(meaning, Navigation)
    (turn,) = meaning.steps
    assert isinstance(turn, Rotate)
    assert turn.thing is not None
    (near,) = meaning.target.where
    assert not turn.thing.is_same(near.things[0])


def test_a_text_without_any_known_word_is_refused() -> None:
    with pytest.raises(lang.CannotRead):
        HINDI.read("lorem ipsum dolor", "navigation")


def test_the_outline_of_a_romanised_text() -> None:
    text = "dayein mudo. laal cone tak jao aur ped ke paas rakhi gend utha lo."
    plain = "दाएँ मुड़ो। लाल कोन तक जाओ और पेड़ के पास रखी गेंद उठा लो।"
    assert [entry.manner for entry in HINDI.outline(text)] == [entry.manner for entry in HINDI.outline(plain)]
    kinds = [entry.thing.kind for entry in HINDI.outline(text) if entry.thing is not None]
    assert kinds == ["cone", "tree"]


@pytest.mark.parametrize("text", ["बैंक के पास दाएँ हो जाना। लाल गेंद उठा लो।", "बैंक पर दाएँ हो जाना है। लाल गेंद उठा लो।"])
def test_to_become_right_is_a_turn(text: str) -> None:
    meaning = HINDI.read(text, "navigation")
    assert isinstance(meaning, Navigation)
    assert [step.direction for step in meaning.steps if isinstance(step, Rotate)] == ["right"]


def test_a_thing_that_is_passed_on_a_side_is_no_turn() -> None:
    meaning = HINDI.read("दाईं ओर वाले पीले शेड के पास से चलो। लाल गेंद उठा लो।", "navigation")
    assert isinstance(meaning, Navigation)
    (walk,) = meaning.steps
    assert isinstance(walk, Walk)
    assert (walk.way, walk.side) == ("past", "right")
