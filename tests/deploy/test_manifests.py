"""Deployment manifests: valid by schema, confined, and consistent with each other and the server."""

import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import kubernetes_validate
import pytest
import yaml

from arramon_server.configuration.config import Config
from arramon_server.configuration.sources import load_configuration
from arramon_server.process.lifecycle import settings_warnings
from tests import ROOT, tiny

DEPLOY = ROOT / "deploy"
FILES = sorted((DEPLOY / "kubernetes").glob("*.yaml"))
MADE_BY_HAND = {"postgres", "arramon", "arramon-tls"}
"""The Secrets, as configuration.yaml and ingress.yaml say."""


def documents() -> Iterator[Any]:
    for path in FILES:
        if path.stem != "kustomization":
            yield from yaml.safe_load_all(path.read_text())


def of_kind(kind: str) -> dict[str, Any]:
    return {each["metadata"]["name"]: each for each in documents() if each["kind"] == kind}


def pods() -> dict[str, Any]:
    """The pods' specifications by the name of what makes them."""
    makers = {**of_kind("Deployment"), **of_kind("StatefulSet"), **of_kind("Job")}
    assert set(makers) == {"arramon", "postgres", "episodes"}
    return {name: maker["spec"]["template"]["spec"] for name, maker in makers.items()}


def containers(pod: Any) -> list[Any]:
    return [*pod.get("initContainers", []), *pod["containers"]]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_manifests_match_the_kubernetes_schema(path: Path) -> None:
    if path.stem == "kustomization":  # of a tool, which Kubernetes' own schemas do not know
        assert yaml.safe_load(path.read_text())["resources"] == sorted_as_applied()
        return
    for document in yaml.safe_load_all(path.read_text()):
        kubernetes_validate.validate(document, kubernetes_validate.latest_version(), strict=True)


def sorted_as_applied() -> list[str]:
    order = ["namespace", "configuration", "postgres", "episodes", "server", "autoscaler", "ingress", "network"]
    assert {path.stem for path in FILES} == {*order, "kustomization"}
    return [f"{name}.yaml" for name in order]


def test_schema_check_rejects_an_invalid_manifest() -> None:
    (deployment,) = of_kind("Deployment").values()
    deployment["spec"]["replica"] = 2
    with pytest.raises(kubernetes_validate.ValidationError):
        kubernetes_validate.validate(deployment, kubernetes_validate.latest_version(), strict=True)


def test_compose_file_matches_its_schema() -> None:
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", "vendor.compose-spec"]
    subprocess.run([*command, str(DEPLOY / "compose.yaml")], check=True, capture_output=True)


@pytest.mark.parametrize("name", ["arramon", "postgres", "episodes"])
def test_pods_run_with_restricted_privileges(name: str) -> None:
    pod = pods()[name]
    assert pod["automountServiceAccountToken"] is False
    assert pod["securityContext"]["runAsNonRoot"] is True
    assert pod["securityContext"]["seccompProfile"] == {"type": "RuntimeDefault"}
    for container in containers(pod):
        assert container["securityContext"] == {
            "allowPrivilegeEscalation": False,
            "readOnlyRootFilesystem": True,
            "capabilities": {"drop": ["ALL"]},
        }
        volumes = {volume["name"] for volume in pod["volumes"]} | {
            claim["metadata"]["name"]
            for maker in of_kind("StatefulSet").values()
            for claim in maker["spec"]["volumeClaimTemplates"]
        }
        assert {mount["name"] for mount in container["volumeMounts"]} <= volumes


@pytest.mark.parametrize("name", ["arramon", "episodes"])
def test_volume_mounts_do_not_make_hidden_data_group_readable(name: str) -> None:
    security = pods()[name]["securityContext"]
    assert (security["fsGroup"], security["fsGroupChangePolicy"]) == (10001, "OnRootMismatch")


def test_compose_containers_are_read_only() -> None:
    services = yaml.safe_load((DEPLOY / "compose.yaml").read_text())["services"]
    assert all(service["read_only"] for service in services.values())


def test_compose_mounts_are_writable_for_their_users() -> None:
    """A folder of the host's that is missing is made as root's; a new volume is as its folder in the image is."""
    compose = yaml.safe_load((DEPLOY / "compose.yaml").read_text())
    mounts = {
        (service["image"], *mount.split(":"))
        for service in compose["services"].values()
        for mount in service["volumes"]
    }
    assert {volume for _, volume, _ in mounts} == set(compose["volumes"]) == {"data", "results"}
    made = made_by_the_dockerfile()
    for image, _, path in mounts:
        target = image.removeprefix("arramon-")
        assert path in made["runtime"] | made[target], f"{path} in {image}"


def test_compose_writes_results_where_its_comment_copies_them_from() -> None:
    text = (DEPLOY / "compose.yaml").read_text()
    agent = yaml.safe_load(text)["services"]["agent"]
    output = agent["command"][agent["command"].index("--output") + 1]
    assert f" cp agent:{output}/. results " in text
    assert output in [mount.partition(":")[2] for mount in agent["volumes"]]


def made_by_the_dockerfile() -> dict[str, set[str]]:
    """The folders that the Dockerfile makes for the images' user, by stage."""
    made: dict[str, set[str]] = {}
    for line in (DEPLOY.parent / "Dockerfile").read_text().splitlines():
        if line.startswith("FROM "):
            folders = made[line.split()[-1]] = set()
        if match := re.search(r"install -d -o arramon -g arramon (\S+)$", line):
            folders.add(match[1])
    return made


def test_manifests_set_only_existing_server_settings() -> None:
    known = {f"ARRAMON_{field.name.upper()}" for field in fields(Config)} | {"ARRAMON_LOG"}
    given = set(of_kind("ConfigMap")["arramon"]["data"])
    (server,) = pods()["arramon"]["containers"]
    given |= {each["name"] for each in server["env"] if each["name"].startswith("ARRAMON_")}
    assert given
    assert given <= known


def test_manifest_settings_are_valid_and_limit_hidden_split_runs(tmp_path: Path) -> None:
    config = load_configuration({}, of_kind("ConfigMap")["arramon"]["data"]).config
    splits = {split.name: split for split in (tiny.write(tmp_path), tiny.write(tmp_path, "test_unseen", hidden=True))}
    assert (config.runs_per_day.of("test_unseen"), config.runs_per_day.of("tiny")) == (3, None)
    assert list(settings_warnings(config, splits)) == []


def test_referenced_secrets_configurations_and_volumes_exist() -> None:
    for pod in pods().values():
        for container in containers(pod):
            for each in container.get("env", []):
                if "valueFrom" in each:
                    assert each["valueFrom"]["secretKeyRef"]["name"] in MADE_BY_HAND
            for each in container.get("envFrom", []):
                assert each["configMapRef"]["name"] in of_kind("ConfigMap")
        for volume in pod["volumes"]:
            assert volume.get("secret", {}).get("secretName", "arramon") in MADE_BY_HAND
            claim = volume.get("persistentVolumeClaim", {}).get("claimName", "episodes")
            assert claim in of_kind("PersistentVolumeClaim")


def test_port_names_are_consistent_across_manifests() -> None:
    (server,) = pods()["arramon"]["containers"]
    ports = {port["name"]: port["containerPort"] for port in server["ports"]}
    settings = of_kind("ConfigMap")["arramon"]["data"]
    variables = {"grpc": "ARRAMON_LISTEN", "web": "ARRAMON_WEB", "metrics": "ARRAMON_METRICS"}
    assert ports == {name: address_port(settings[variable]) for name, variable in variables.items()}
    probes = [server[f"{kind}Probe"]["httpGet"]["port"] for kind in ("startup", "liveness", "readiness")]
    service = of_kind("Service")["arramon"]["spec"]["ports"]
    rules = [rule for ingress in of_kind("Ingress").values() for rule in ingress["spec"]["rules"]]
    backends = [path["backend"]["service"]["port"]["name"] for rule in rules for path in rule["http"]["paths"]]
    policy = of_kind("NetworkPolicy")["arramon"]["spec"]["ingress"]
    allowed = [port["port"] for rule in policy for port in rule["ports"]]
    assert {*probes, *(port["targetPort"] for port in service), *backends, *allowed} == set(ports)
    assert [port["name"] for port in service] == ["grpc", "web"]


def address_port(address: str) -> int:
    return int(address.rpartition(":")[2])
