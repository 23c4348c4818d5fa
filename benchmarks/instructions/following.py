"""Scores of the follower on instructions before any is rejected: `python -m benchmarks.instructions.following`.

Draws the first valid draft of each episode and the first texts that pass the quality checks, and plays them in every
language. `arramon-server generate` keeps only some of these, so this measures the quality of the instructions before
selection. Prints the paper's table, and the share that would be kept; `--json` also writes it to a file.
"""

import arramon_lang as lang
from arramon_dataset.generation import GenerationSite
from arramon_dataset.generation.check import faults_of_episode
from arramon_dataset.generation.split_specs import select_specs
from arramon_dataset.instruction_writer import WriterFactory, further_languages, passes_trial
from arramon_dataset.plans import build_section, read_plan
from arramon_dataset.trial import play
from arramon_server.scoring.aggregate import ROWS, aggregate
from arramon_server.scoring.episode_scores import EpisodeScores
from benchmarks.common import add_json, parser_of, positive_int, text_table, write_json

METRICS = ("nDTW", "CTC-0", "CTC-3", "CTC-5", "CTC-7", "rPOD", "PTC", "rPOD@CTC-3", "PTC@CTC-3")


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    parser.add_argument("--split", default="val_unseen", help="an open split (default: %(default)s)")
    parser.add_argument(
        "--episodes", type=positive_int, default=100, help="number of its episodes (default: %(default)s)"
    )
    parser.add_argument("--seed", default="1", help="seed as for `arramon-server generate` (default: %(default)s)")
    parser.add_argument(
        "--languages", default=",".join(lang.required()), help="required and further ones (default: %(default)s)"
    )
    add_json(parser)
    arguments = parser.parse_args()

    (split,) = select_specs([arguments.split])
    episodes = list(split.episodes())[: arguments.episodes]
    languages = tuple(arguments.languages.split(","))
    writer = WriterFactory(further_languages(languages), trial=True)()
    plans = {section: read_plan(section) for _, section in episodes}
    sites = {section: GenerationSite(build_section(plan, arguments.seed), plan) for section, plan in plans.items()}
    scores: dict[str, list[EpisodeScores]] = {code: [] for code in languages}
    kept = rejected = 0
    for episode_id, section in episodes:
        site = sites[section]
        for attempt in range(20):
            names = (arguments.seed, split.name, episode_id, attempt)
            draft = site.sampler.draw(episode_id, (*names, "draft"))
            texts = next(writer.candidates(draft, site, (*names, "words")), None)
            if texts is not None and not faults_of_episode(draft, site.solids, site.physics):
                break
            rejected += 1
        else:
            raise SystemExit(f"no instruction could be written for 20 drafts of episode {episode_id}")
        world = site.in_episode(draft.layout)
        played = {code: play(writer.make_follower(), draft.with_instructions(texts), code, world) for code in texts}
        for code, score in played.items():
            scores[code].append(score)
        kept += all(passes_trial(played[code]) for code in lang.required())

    rows: dict[str, dict[str, dict[str, float]]] = {}
    print(
        f"{len(episodes)} episodes of {split.name}; {rejected} further drafts had no valid text; {kept} would be kept; "
        f"written: {', '.join(f'{len(found)} in {code}' for code, found in scores.items())}"
    )
    lines = []
    for code in filter(scores.get, languages):
        table = aggregate(scores[code])
        rows[code] = {row: {name: table.rows[row][name].mean for name in METRICS} for row in ROWS}
        lines += [[f"{code} {row}", *(f"{values[name]:.3f}" for name in METRICS)] for row, values in rows[code].items()]
    print(text_table(["", *METRICS], lines))
    written = {code: len(found) for code, found in scores.items()}
    counts = {"episodes": len(episodes), "drafts without words": rejected, "kept": kept, "written": written}
    write_json(arguments.json, {"split": split.name, **counts, "scores": rows})


if __name__ == "__main__":
    main()
