"""How well the follower is led by generated instructions before any is thrown away: `python benchmarks/following.py`.

Draws the first valid draft of each episode and the first texts that pass the quality checks, and plays them in every
language. What `arramon-server generate` keeps of these is a part of them, so this says how good the instructions are as
they come. Prints the paper's table, and the share that would be kept; `--output` also writes it as JSON.
"""

import argparse
import json
import sys
from pathlib import Path

import lang
from server.episodes.generate import Site
from server.episodes.generate.check import problems
from server.episodes.generate.sizes import chosen
from server.episodes.plans import build_section, read_plan
from server.generating import make_scribe, passes, room_camera
from server.scoring.aggregate import ROWS, aggregate
from server.scoring.episode import EpisodeScores
from server.trial import Place, play

METRICS = ("nDTW", "CTC-0", "CTC-3", "CTC-5", "CTC-7", "rPOD", "PTC", "rPOD@CTC-3", "PTC@CTC-3")


def main() -> int:
    """Measures, and prints a table."""
    parser = argparse.ArgumentParser(prog="following", description=__doc__.split("\n\n")[0])
    parser.add_argument("--split", default="val_unseen", help="an open one (default: %(default)s)")
    parser.add_argument("--episodes", type=int, default=100, help="how many of its episodes (default: %(default)s)")
    parser.add_argument("--seed", default="1", help="as `arramon-server generate` takes it (default: %(default)s)")
    parser.add_argument("--output", type=Path, help="JSON file")
    arguments = parser.parse_args()

    (split,) = chosen([arguments.split])
    episodes = list(split.episodes())[: arguments.episodes]
    scribe, languages = make_scribe(), lang.available()
    sites = {section: Site(build_section(read_plan(section), arguments.seed)) for _, section in episodes}
    scores: dict[str, list[EpisodeScores]] = {code: [] for code in languages}
    kept = unsaid = 0
    for episode_id, section in episodes:
        site = sites[section]
        for attempt in range(20):
            names = (arguments.seed, split.name, episode_id, attempt)
            draft = site.drawer.draw(episode_id, (*names, "draft"))
            texts = next(scribe.tellings(draft, site, (*names, "words")), None)
            if texts is not None and not problems(draft, site.solids, site.world):
                break
            unsaid += 1
        else:
            raise SystemExit(f"nothing could be said of 20 drafts of episode {episode_id}")
        place = Place(site.world, site.camera, room_camera())
        played = {code: play(scribe.make_follower(), draft.spoken(texts), code, place) for code in languages}
        for code, score in played.items():
            scores[code].append(score)
        kept += all(map(passes, played.values()))

    rows: dict[str, dict[str, dict[str, float]]] = {}
    print(f"{len(episodes)} episodes of {split.name}; {unsaid} more drafts had no words; {kept} would be kept")
    print(" " * 12 + "".join(f"{name:>12}" for name in METRICS))
    for code in languages:
        table = aggregate(scores[code])
        rows[code] = {row: {name: table.rows[row][name].mean for name in METRICS} for row in ROWS}
        for row, values in rows[code].items():
            print(f"{code} {row:9}" + "".join(f"{values[name]:12.3f}" for name in METRICS))
    if arguments.output:
        counts = {"episodes": len(episodes), "drafts without words": unsaid, "kept": kept}
        arguments.output.write_text(json.dumps({"split": split.name, **counts, "scores": rows}, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
