"""Command `python -m arramon_agents.vlm estimate`: what a run would take in calls, tokens and money."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from arramon.strict_json import NotJsonError, read_json
from arramon_agents.requirements import require
from arramon_agents.vlm import REQUIRED, make_agent
from arramon_agents.vlm.settings import ModelSettings, read_settings
from arramon_agents.vlm.usage import read_price
from arramon_client.errors import AgentLoadError, ArramonClientError
from arramon_client.plugin.arguments import check_signature, parse_arguments, parse_value

FAILED = 2
"""Exit status: wrong arguments."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command, and return its exit status."""
    parser = argparse.ArgumentParser(prog="python -m arramon_agents.vlm", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    form = commands.add_parser("estimate", help="state calls, tokens and cost of a run; makes no call")
    form.add_argument("--episodes", type=int, required=True, metavar="N", help="episodes of the run")
    form.add_argument("--lang", default="en", metavar="CODE", help="language of the run (default: en)")
    form.add_argument(
        "--agent-arg", action="append", default=[], metavar="NAME=VALUE", help="as for arramon-client; can be repeated"
    )
    form.add_argument("--trace", type=Path, metavar="FILE", help="the trace of a few episodes, to estimate from it")
    options = parser.parse_args(argv)
    try:
        lines = _estimate(options)
    except ArramonClientError as error:
        sys.stderr.write(f"error: {error}\n")
        return FAILED
    sys.stdout.write("\n".join(lines) + "\n")
    return 0


def _estimate(options: argparse.Namespace) -> list[str]:
    """Return the lines to print.

    Raises:
        ArramonClientError: if an argument is wrong.
    """
    require(REQUIRED, "agents.vlm", "vlm")
    from arramon_agents.vlm import estimate

    if options.episodes < 1:
        raise AgentLoadError(f"--episodes is {options.episodes}; expected 1 or more")
    given = {name: parse_value(typed) for name, typed in parse_arguments(options.agent_arg).items()}
    check_signature(make_agent, given, "agents.vlm")
    settings = read_settings(given)
    price = read_price(settings.prices, settings.model)
    if options.trace is not None:
        episodes, mean = estimate.estimate_from_trace(_records(options.trace))
        said = f"{settings.model}, {_episodes(options.episodes)}, by the {_episodes(episodes)} of {options.trace}:"
        return [said, estimate.shown("expected", mean.times(options.episodes), price)]
    return _by_settings(options, settings)


def _by_settings(options: argparse.Namespace, settings: ModelSettings) -> list[str]:
    from arramon_agents.vlm import estimate

    price = read_price(settings.prices, settings.model)
    size = settings.image_size or 224
    rates = estimate.rates_of(settings, price, options.lang, size)
    prompts = estimate.prompts_of(settings, options.lang)
    lines = [f"{settings.model}, {_episodes(options.episodes)}, plan={settings.plan}, window={settings.window}:"]
    for name, at_most in (("expected", False), ("at most", True)):
        episode = estimate.estimate_episode(settings, prompts, rates, at_most=at_most)
        lines.append(estimate.shown(name, episode.times(options.episodes), price))
    frames = f"{rates.image} tokens a frame" if settings.images else "no frames"
    lines += [
        f"Assumed: {rates.characters:g} characters a token, {frames}, nothing cached; expected: the model arrives in "
        f"{estimate.DETOUR:g} times the shortest way, with full plans. Reasoning tokens come on top.",
        "For a better estimate play two episodes (--episodes 2), and add --trace arramon-results/RUN.vlm.jsonl",
    ]
    return lines


def _episodes(number: int) -> str:
    return f"{number} episode{'s' if number != 1 else ''}"


def _records(path: Path) -> list[dict[str, object]]:
    """Return the records of a trace.

    Raises:
        AgentLoadError: if it cannot be read.
    """
    try:
        lines = [line for line in path.read_bytes().split(b"\n") if line.strip()]
        return [content for content in map(read_json, lines) if isinstance(content, dict)]
    except OSError as error:
        raise AgentLoadError(f"the trace {path} cannot be read: {error.strerror}") from error
    except NotJsonError as error:
        raise AgentLoadError(f"the trace {path} {error}") from error


if __name__ == "__main__":
    sys.exit(main())
