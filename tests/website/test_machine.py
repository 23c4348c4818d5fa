"""Files for programs: schemas hold for real files and refuse wrong ones, OpenAPI for real answers."""

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml
from jsonschema import Draft202012Validator

from arramon_client import Run
from arramon_dataset.release.importer import import_release
from arramon_server.configuration.config import Config
from arramon_server.configuration.setting import settings_of
from tests import ROOT
from tests.web.conftest import shown as shown
from tests.web.leaderboard_site import OPEN_RUN, LeaderboardSite
from website.machine.files import files, llms
from website.machine.openapi import openapi
from website.machine.schemas import schemas

SAMPLE = ROOT / "examples" / "sample"

SCHEMAS = schemas()


def faults(name: str, content: object) -> list[str]:
    return [f"{error.json_path}: {error.message}" for error in Draft202012Validator(SCHEMAS[name]).iter_errors(content)]


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("data")
    import_release([SAMPLE / "sample.json", SAMPLE / "sample_hindi.json"], folder)
    return folder / "splits" / "sample"


@pytest.mark.parametrize("name", SCHEMAS)
def test_schemas_are_schemas(name: str) -> None:
    Draft202012Validator.check_schema(SCHEMAS[name])
    assert SCHEMAS[name]["title"]


def test_data_files_are_valid(data: Path) -> None:
    header, *episodes = map(json.loads, (data / "episodes.jsonl").read_text(encoding="utf-8").splitlines())
    assert faults("episode-file-header", header) == []
    assert len(episodes) == 24
    assert [fault for episode in episodes for fault in faults("episode", episode)] == []
    for path in (data / "sections").glob("*.json"):
        assert faults("section", json.loads(path.read_text(encoding="utf-8"))) == []
    for path in (data / "provenance").glob("*.json"):
        assert faults("provenance", json.loads(path.read_text(encoding="utf-8"))) == []
    del episodes[0]["start"]["heading"]
    assert faults("episode", episodes[0]) == ["$.start: 'heading' is a required property"]


def test_results_and_receipts_of_a_run_are_valid(data: Path) -> None:
    options: dict[str, Any] = {"split": "sample", "data": data.parents[1], "sensors": ("rgb",), "episodes": 2}
    with Run.create(language="hi", agent="gives up", **options) as run:
        for episode in run.episodes():
            episode.give_up("this test asks for files alone")
        report, receipt = run.report(), run.receipt()
    file = receipt.file_content()
    assert faults("results", report) == []
    assert faults("receipt-file", file) == []
    assert faults("receipt", json.loads(file["payload"])) == []
    report["metrics"]["total"]["nDTW"]["mean"] = 2.0
    assert faults("results", report) == ["$.metrics.total.nDTW.mean: 2.0 is greater than the maximum of 1"]


def test_the_documented_settings_are_valid() -> None:
    text = (ROOT / "docs" / "reference" / "configuration.md").read_text(encoding="utf-8")
    example = tomllib.loads(text.partition("```toml\n")[2].partition("```")[0])
    assert example
    assert faults("settings", example) == []
    assert SCHEMAS["settings"]["properties"].keys() == {
        name for name, each in settings_of(Config).items() if not each.description.internal
    }
    assert faults("settings", {"workers": 0}) == ["$.workers: 0 is less than the minimum of 1"]
    assert len(faults("settings", {"step": 3})) == 1


ANSWERS = {
    "/standings.json": "/standings.json?split=open&language=en",
    "/epochs.json": "/epochs.json",
    "/runs/{run}/actions.json": f"/runs/{OPEN_RUN}/actions.json",
    "/runs/{run}/receipt.json": f"/runs/{OPEN_RUN}/receipt.json",
}


def test_answers_are_as_openapi_describes_them(shown: LeaderboardSite) -> None:
    described: dict[str, Any] = openapi()
    assert ANSWERS.keys() == described["paths"].keys()
    for path, address in ANSWERS.items():
        answer = shown.site.get(address)
        assert answer.status == 200, address
        ok = described["paths"][path]["get"]["responses"]["200"]
        schema = {**ok["content"]["application/json"]["schema"], "components": described["components"]}
        content = json.loads(answer.text)
        assert [error.message for error in Draft202012Validator(schema).iter_errors(content)] == [], path
        assert list(Draft202012Validator(schema).iter_errors({}))
    assert shown.site.get(f"/runs/{'0' * 32}/receipt.json").status == 404


def test_the_list_for_language_models_names_every_page() -> None:
    listed = llms()
    for purpose in ("tutorials", "how-to", "reference", "explanation", "results", "project"):
        for path in (ROOT / "docs" / purpose).glob("*.md"):
            assert path.stem == "index" or f"({purpose}/{path.stem}.html)" in listed
    assert {"llms.txt", "openapi.json", "schemas/episode.json", "schemas/results.json"} <= files().keys()


def test_the_citation_is_of_the_paper_and_of_this_version() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert cited["cff-version"] == "1.2.0"
    assert (cited["version"], cited["license"]) == (project["version"], project["license"])
    paper = cited["preferred-citation"]
    assert [each["family-names"] for each in paper["authors"]] == ["Kim", "Zala", "Burri", "Tan", "Bansal"]
    citing = (ROOT / "docs" / "project" / "citing.md").read_text(encoding="utf-8")
    assert paper["url"] in (ROOT / "README.md").read_text(encoding="utf-8")
    assert f'url = "{paper["url"]}"' in citing
    assert " and ".join(f"{each['family-names']}, {each['given-names']}" for each in paper["authors"]) in citing
    assert f"{paper['collection-title']}" in citing
    assert f'version = "{cited["version"]}"' in citing
    assert f'license = "{cited["license"]}"' in citing
