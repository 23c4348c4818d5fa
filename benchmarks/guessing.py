"""What the follower reaches without the route: `python benchmarks/guessing.py --episodes 20`.

Plays kept episodes in English with the full navigation texts, with the target's name alone, and with the texts of
another episode; the room's texts are always the full ones. The less a name alone leads to the target, the more the
route is worth. Prints CTC-3 and nDTW over both turns.
"""

import argparse
from collections import defaultdict
from collections.abc import Mapping

import lang
from lang.meaning import Navigation, Thing
from server.dataset.generation import Site
from server.dataset.generation.check import problems
from server.dataset.generation.draft import Draft
from server.dataset.generation.sizes import select_plans
from server.dataset.instruction_writer import make_instruction_writer, passes, room_camera
from server.dataset.plans import build_section, read_plan
from server.dataset.randomness import seeded
from server.dataset.trial import TrialWorld, play
from server.episodes.episode import Instructions

LANGUAGE = "en"

Texts = tuple[Instructions, Instructions]


def name_alone(draft: Draft, texts: Texts) -> Texts:
    """Return the texts with only the targets named in navigation."""
    named = []
    for number, (turn, text) in enumerate(zip(draft.turns, texts, strict=True)):
        kind = turn.target.type
        meaning = Navigation((), Thing(kind.kind, kind.colour, kind.pattern))
        said = lang.load(LANGUAGE).write(meaning, seeded(draft.episode_id, number, "name"))
        named.append(Instructions(said, text.assembly))
    return named[0], named[1]


def main() -> None:
    """Run the benchmark and print its table."""
    parser = argparse.ArgumentParser(prog="guessing", description=__doc__.split("\n\n")[0])
    parser.add_argument("--split", default="val_seen", help="an open split (default: %(default)s)")
    parser.add_argument("--episodes", type=int, default=20, help="number of its episodes (default: %(default)s)")
    parser.add_argument("--seed", default="1", help="seed as for `arramon-server generate` (default: %(default)s)")
    arguments = parser.parse_args()

    (split,) = select_plans([arguments.split])
    writer = make_instruction_writer()
    sites: dict[str, Site] = {}
    scores: dict[str, list[Mapping[str, float]]] = defaultdict(list)
    other: Texts | None = None
    for episode_id, section in list(split.episodes())[: arguments.episodes]:
        if section not in sites:
            plan = read_plan(section)
            sites[section] = Site(build_section(plan, arguments.seed), plan)
        site = sites[section]
        world = TrialWorld(site.world, site.camera, room_camera())
        for attempt in range(40):
            names = (arguments.seed, split.name, episode_id, attempt)
            draft = site.sampler.draw(episode_id, (*names, "draft"))
            texts = None if problems(draft, site.solids, site.world) else writer(draft, site, (*names, "words"))
            if texts is not None:
                break
        else:
            continue
        full = texts[LANGUAGE]
        variants = {"full text": full, "target's name alone": name_alone(draft, full)}
        if other is not None:
            swapped = [Instructions(o.navigation, f.assembly) for o, f in zip(other, full, strict=True)]
            variants["another episode's text"] = swapped[0], swapped[1]
        other = full
        for name, variant in variants.items():
            played = play(writer.make_follower(), draft.with_instructions({LANGUAGE: variant}), LANGUAGE, world)
            scores[name] += played.turns
            assert name != "full text" or passes(played)
    for name, turns in scores.items():
        mean = {metric: sum(turn[metric] for turn in turns) / len(turns) for metric in ("CTC-3", "nDTW")}
        print(f"{name:24} {len(turns):4} turns  CTC-3 {mean['CTC-3']:.2f}  nDTW {mean['nDTW']:.2f}")


if __name__ == "__main__":
    main()
