"""Training and evaluation of the statistical check of instructions (`dataset/alignment`).

    python -m benchmarks.instructions.alignment [--train] [--show N] [--lang en hi]

It is trained on the development half of the free paraphrases, and measured on their test half: how often a text fits
its own route better than the same route mirrored, than with one turn the other way, and than nine other routes; and, as
the grammar's texts for the same episodes are known to lead the follower, how often it contradicts them. --show prints
texts of the grammar that it contradicts. --train learns anew and writes the models into the package. Takes some
minutes, as the routes are looked at through the camera.
"""

from collections.abc import Mapping
from random import Random

from arramon_dataset.alignment.model import DATA, MOST_BETTER, OTHERS, AlignmentModel, contradicts_route, load
from arramon_dataset.alignment.route_tokens import Tokens, mirrored, tokens_of
from arramon_dataset.generation.site import GenerationSite
from arramon_dataset.paraphrases.collection import HALVES, generated_episodes, paraphrased_section, paraphrases
from arramon_dataset.paraphrases.route_facts import route_facts
from arramon_dataset.randomness import seeded
from benchmarks.common import parser_of
from benchmarks.instructions.alignment_training import learn, save

Key = tuple[str, int]

NINE = 9


def routes_of(episodes: set[str]) -> dict[Key, Tokens]:
    """Return the route tokens of both turns of paraphrased episodes."""
    site = GenerationSite(paraphrased_section())
    return {
        (episode.episode_id, number): tokens_of(
            route_facts(episode, number, site), episode.turns[number - 1].target.type
        )
        for episode in generated_episodes()
        if episode.episode_id in episodes
        for number in (1, 2)
    }


def texts_of(half: str, language: str) -> dict[Key, str]:
    """Return the navigation paraphrases of a half."""
    return {
        (text.episode, text.turn): text.navigation
        for text in paraphrases()
        if (text.half, text.language) == (half, language)
    }


def with_one_turn_reversed(route: Tokens, random: Random) -> Tokens | None:
    """Return the route with one random turn reversed, or None if it has no turns."""
    turns = [number for number, token in enumerate(route) if token in ("turn:left", "turn:right")]
    if not turns:
        return None
    chosen = random.choice(turns)
    return (*route[:chosen], *mirrored(route[chosen : chosen + 1]), *route[chosen + 1 :])


def measure(model: AlignmentModel, texts: Mapping[Key, str], routes: Mapping[Key, Tokens]) -> str:
    """Return the share of texts that fit their own route better than others."""
    random = seeded("alignment")
    keys = sorted(texts)
    found: dict[str, list[bool]] = {"mirrored": [], "one turn the other way": [], "nine others": []}
    for key in keys:
        own = model.score(texts[key], routes[key])
        found["mirrored"].append(model.margin(texts[key], routes[key]) > 0.0)
        turned = with_one_turn_reversed(routes[key], random)
        if turned is not None:
            found["one turn the other way"].append(own > model.score(texts[key], turned))
        others = random.sample([other for other in keys if other != key], NINE)
        found["nine others"].append(all(own > model.score(texts[key], routes[other]) for other in others))
    return ", ".join(f"{name} {sum(right) / len(right):.3f} of {len(right)}" for name, right in found.items())


def _contradicted(language: str, routes: Mapping[Key, Tokens], show: int) -> str:
    """Return the share of the grammar's texts that are rejected, with the right route and with wrong ones."""
    episodes = {episode.episode_id: episode for episode in generated_episodes()}
    texts = {
        (name, number): episodes[name].instructions[language][number - 1].navigation for name, number in sorted(routes)
    }
    random, keys = seeded("alignment"), sorted(texts)
    counts = {"its own route": 0, "mirrored": 0, "another's": 0}
    for key, text in texts.items():
        other = routes[random.choice([each for each in keys if each[0] != key[0]])]
        for name, route in zip(counts, (routes[key], mirrored(routes[key]), other), strict=True):
            counts[name] += contradicts_route(text, language, route)
        if show > 0 and contradicts_route(text, language, routes[key]):
            show -= 1
            print(f"  {key[0]}/{key[1]}: {text}\n    {' '.join(routes[key])}")
    return ", ".join(f"{name} {count / len(texts):.3f}" for name, count in counts.items())


def main() -> None:
    """Train with --train, and print the figures."""
    parser = parser_of(__doc__)
    parser.add_argument("--train", action="store_true", help="train and write the models")
    parser.add_argument("--show", type=int, default=0, metavar="N", help="print N texts that are contradicted")
    parser.add_argument("--lang", nargs="+", default=["en", "hi"], help="languages (default: both)")
    arguments = parser.parse_args()
    ids = {half: {text.episode for text in paraphrases() if text.half == half} for half in HALVES}
    development, test = HALVES
    if arguments.train:
        known = routes_of(ids[development])
        for language in arguments.lang:
            texts = texts_of(development, language)
            save(learn([(texts[key], known[key]) for key in sorted(texts)], OTHERS), DATA / f"{language}.json.gz")
        load.cache_clear()
    routes = routes_of(ids[test])
    for language in arguments.lang:
        model = load(language)
        if model is None:
            parser.error(f"no model of {language}; train one with --train")
        print(f"{language} paraphrases fit their own route better: {measure(model, texts_of(test, language), routes)}")
        contradicted = _contradicted(language, routes, arguments.show)
        print(f"{language} the grammar's texts contradict (more than {MOST_BETTER} of {OTHERS}): {contradicted}")


if __name__ == "__main__":
    main()
