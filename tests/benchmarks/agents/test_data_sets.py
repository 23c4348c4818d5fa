"""Tables of agents on several data sets: each set apart, then the episodes of all sets together."""

from benchmarks.agents import data_sets
from benchmarks.agents.results_tables import SeedGroup
from tests.benchmarks.agents.test_results_tables import cells, run


def groups(vl: float, blind: float) -> list[SeedGroup]:
    """Scores on one data set of three episodes, whose first turns begin with a number of each agent."""
    return [
        SeedGroup("vl", "en", [run("vl", 1, vl)]),
        SeedGroup("vision_only", "any", [run("vision_only", 1, blind, "any")]),
    ]


def tables_by_title(vl: tuple[float, float], blind: tuple[float, float]) -> dict[str, list[list[str]]]:
    means, differences = data_sets.tables([groups(*each) for each in zip(vl, blind, strict=True)]).split("## ")[1:]
    first = means.split("nDTW:\n\n")[1].split("\n\n")[0]
    second = differences.split("nDTW:\n\n")[1].split("\n\n")[0]
    return {"means": cells(first), "differences": cells(second)}


def test_means_of_each_set_and_of_all_episodes_with_their_interval() -> None:
    table = tables_by_title((1.0, 0.0), (0.0, 0.0))["means"]
    # Episodes have .5, .375, .25 on the first set and 0, .375, .25 on the second; 2.571 is Student's quantile.
    assert table[0] == ["`vl`", "en", "0.375", "0.208", "0.292 (0.112 to 0.471)"]
    assert table[1][:4] == ["`vision_only`", "any", "0.208", "0.208"]


def test_differences_are_paired_by_episode_within_each_set() -> None:
    table = tables_by_title((1.0, 0.0), (0.0, 0.0))["differences"]
    # The agents differ in one episode of the first set.
    assert table == [
        ["`vl` - `vision_only`", "en", "+0.167 (-0.550 to +0.884)", "+0.000 (+0.000 to +0.000)",
         "+0.083 (-0.131 to +0.298)"]
    ]  # fmt: skip
