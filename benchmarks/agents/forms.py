"""Scores of agents on a split's texts, and their paired drop on the same episodes with texts in other forms.

    python -m benchmarks.agents.forms --data DIR [--split val_unseen] [--agents agents.follower,agents.vl]
                                      [--episodes N] [--forms terse,romanised] [--json FILE]

Plays in process, with the server's rules and camera and the sensors that the agent asks for, the episodes of a split
and of those that `arramon-server forms` wrote from it. A drop is the mean difference to the same episodes' first texts
in the same language, with its 95% interval. The script consistency rate is the share of turns with the same outcome
(CTC-3) with both texts: an agent that understands what is said, and not how it is typed, has 1.
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from arramon_agents.training.rollouts import RolloutPlan, play_turns
from arramon_dataset.forms.forms import FORMS
from arramon_dataset.forms.splits import PREFIX, form_split_name
from arramon_server.episodes.splits import Split, read_split, split_folder
from arramon_server.scoring.intervals import Floats
from arramon_server.scoring.paired import difference_bounds
from benchmarks.common import add_json, named_agent, parser_of, positive_int, text_table, write_json

METRIC = "CTC-3"

OTHER_METRICS = ("nDTW", "PTC")

Scores = Mapping[str, Floats]
"""Scores of both turns of each episode, (episodes, 2), by metric."""


def played(data: Path, agent: str, split: str, language: str, ids: Sequence[str]) -> Scores:
    """Return an agent's scores on episodes of a split in one language, in the order of their ids."""
    turns = play_turns(named_agent(agent), RolloutPlan(data, split, (language,), 0, chosen=tuple(ids)))
    return {
        metric: np.array([[turns[name][turn][metric] for turn in ("turn 1", "turn 2")] for name in ids])
        for metric in (METRIC, *OTHER_METRICS)
    }


def compared(first: Scores, form: Scores, strata: Sequence[int]) -> dict[str, float]:
    """Return the scores in a form, the drop with its interval, and the script consistency rate.

    Args:
        first: scores with the first texts.
        form: scores of the same episodes with texts in the form.
        strata: number of each episode's section.
    """
    drop, low, high = difference_bounds((first[METRIC] - form[METRIC]).mean(axis=1), np.array(strata))
    means = {metric: float(form[metric].mean()) for metric in (METRIC, *OTHER_METRICS)}
    return {**means, "drop": drop, "low": low, "high": high, "same": float((first[METRIC] == form[METRIC]).mean())}


def main() -> None:
    """Play the splits and print a table."""
    parser = parser_of(__doc__)
    _add_options(parser)
    arguments = parser.parse_args()
    split = _split(arguments, arguments.split)
    rows: list[list[str]] = []
    results: dict[str, dict[str, float]] = {}
    agents = arguments.agents.split(",")
    for agent in agents:
        named_agent(agent)  # A wrong name is reported before anything is played.
    for agent in agents:
        first: dict[str, Scores] = {}
        for form in arguments.forms.split(",") if arguments.forms else FORMS:
            name = form_split_name(split.name, form)
            if not arguments.forms and not split_folder(arguments.data, name).is_dir():
                continue
            other = _split(arguments, name)
            if not other.source.startswith(PREFIX):
                raise SystemExit(f"split {name} is not one of `arramon-server forms`: {other.source}")
            for code in other.languages:
                ids = [each.episode_id for each in split.in_playing_order(code)][: arguments.episodes]
                strata = [sorted(split.sections).index(split.episodes[each].section) for each in ids]
                if code not in first:
                    first[code] = played(arguments.data, agent, split.name, code, ids)
                    rows.append([agent, code, "first texts", f"{first[code][METRIC].mean():.3f}", "", "", ""])
                result = compared(first[code], played(arguments.data, agent, name, code, ids), strata)
                results[f"{agent} {code} {form}"] = result
                interval = f"{result['drop']:+.3f} ({result['low']:+.3f} to {result['high']:+.3f})"
                values = [f"{result[metric]:.3f}" for metric in (METRIC, "nDTW")]
                rows.append([agent, code, form, *values, interval, f"{result['same']:.3f}"])
    print(text_table(["agent", "language", "form", METRIC, "nDTW", f"drop of {METRIC}", "same outcome"], rows))
    write_json(arguments.json, results)


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--data", type=Path, required=True, metavar="DIR", help="data folder with the splits")
    parser.add_argument("--split", default="val_unseen", help="the split with the first texts (default: %(default)s)")
    parser.add_argument("--agents", default="agents.follower", help="agents, such as agents.follower,agents.vl")
    parser.add_argument("--episodes", type=positive_int, default=20, help="episodes to play (default: %(default)s)")
    parser.add_argument("--forms", default="", help="forms (default: all whose splits exist)")
    add_json(parser)


def _split(arguments: argparse.Namespace, name: str) -> Split:
    folder = split_folder(arguments.data, name)
    if not folder.is_dir():
        raise SystemExit(f"there is no split {name!r} in {arguments.data}")
    return read_split(folder)


if __name__ == "__main__":
    main()
