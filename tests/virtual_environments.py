"""Fresh virtual environments with this project's distributions and their dependencies."""

import os
import shlex
import subprocess
import sys
import venv
from collections.abc import Iterable, Iterator, Sequence
from importlib.metadata import Distribution, distribution, distributions
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check")
LIMIT = 1000
"""Seconds after which what hangs is ended."""


class Environment:
    """A virtual environment that sees nothing of the source tree.

    What the wheels require is linked in from the environment of the tests, as a download would take minutes: that and
    nothing else of it, so that a requirement that was not declared is missing here too.

    Args:
        folder: of the new environment.
        wheels: to install.
        more: further requirements, such as "numba", or "arramon-agents[torch]" for an extra of a wheel.
    """

    def __init__(self, folder: Path, wheels: Sequence[Path], more: Sequence[str] = ()) -> None:
        venv.create(folder, symlinks=True)
        self.folder = folder
        (self.site,) = folder.glob("lib/python3*/site-packages")
        if wheels:
            self.install(wheels)
        self.ours = self.distributions()
        for required in self._required(more):
            _link(required, self.site)
        self.check()

    def distributions(self) -> set[str]:
        """The names of all that is installed."""
        return {canonicalize_name(each.name) for each in distributions(path=[str(self.site)])}

    def install(self, wheels: Sequence[Path]) -> None:
        """Installs wheels alone."""
        self._pip("install", "--quiet", "--no-compile", "--no-index", "--no-deps", *map(str, wheels))

    def install_sources(self, folder: Path, *arguments: str) -> None:
        """Installs projects as from a clone, without an index: what they require must be there, and setuptools."""
        command = [*PIP, "--python", str(self.folder), "install", "--quiet", "--no-index", "--no-build-isolation"]
        self._run([*command, *arguments], folder, self.variables())

    def uninstall(self, names: Iterable[str]) -> None:
        """Removes distributions that `install` or `download` brought; not those that are links."""
        self._pip("uninstall", "--quiet", "--yes", *names)

    def download(self, *requirements: str) -> "subprocess.CompletedProcess[str]":
        """Installs what is in the index that pip is configured with, and returns what pip said.

        Options of pip may be among the requirements.

        What is there already must stay as it is, as it may be a link into the tests' environment.
        """
        pins = self.folder / "pins.txt"
        pins.write_text("".join(f"{each.name}=={each.version}\n" for each in distributions(path=[str(self.site)])))
        options = ("--no-compile", "--upgrade-strategy", "only-if-needed", "--constraint", str(pins))
        command = [*PIP, "--python", str(self.folder), "install", *options, *requirements]
        given = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
        return subprocess.run(command, cwd=self.folder, env=given, capture_output=True, text=True, timeout=LIMIT)

    def check(self) -> None:
        """Fails where something that is installed lacks a requirement."""
        self._pip("check")

    def run(self, command: str, cwd: Path, **variables: str) -> "subprocess.CompletedProcess[str]":
        """Runs one of the environment's programs to its end, with the arguments behind it as in a shell."""
        given, environment = self.command(command), self.variables(**variables)
        return subprocess.run(given, cwd=cwd, env=environment, capture_output=True, text=True, timeout=LIMIT)

    def command(self, command: str) -> list[str]:
        program, *arguments = shlex.split(command)
        return [str(self.folder / "bin" / program), *arguments]

    def variables(self, **more: str) -> dict[str, str]:
        """The environment variables of a stranger's shell, and more."""
        return {"PATH": os.environ["PATH"], "HOME": str(self.folder), "LANG": "C.UTF-8", **more}

    def _pip(self, *arguments: str) -> None:
        # Somewhere else: in the source tree its own metadata would be found.
        self._run([*PIP, "--python", str(self.folder), *arguments], self.folder, self.variables())

    def _run(self, command: Sequence[str], cwd: Path, variables: dict[str, str]) -> None:
        done = subprocess.run(command, cwd=cwd, env=variables, capture_output=True, text=True, timeout=LIMIT)
        assert done.returncode == 0, done.stdout + done.stderr

    def _required(self, more: Sequence[str]) -> Iterator[Distribution]:
        """All that the installed wheels require, and more, and what that requires, but not the wheels."""
        ours = {canonicalize_name(each.name): each for each in distributions(path=[str(self.site)])}
        seen = {(name, "") for name in ours}
        waiting = [each for mine in ours.values() for each in _requirements(mine, ("",))]
        waiting += map(Requirement, more)
        while waiting:
            requirement = waiting.pop()
            name = canonicalize_name(requirement.name)
            new = {(name, extra) for extra in ("", *requirement.extras)} - seen
            if new:
                seen |= new
                found = ours.get(name) or distribution(requirement.name)
                if name not in ours:
                    yield found
                waiting += _requirements(found, [extra for _, extra in new])


def _requirements(of: Distribution, extras: Iterable[str]) -> list[Requirement]:
    """What a distribution with these extras requires here; "" stands for none."""
    every = [Requirement(line) for line in of.requires or ()]
    return [each for each in every if not each.marker or any(each.marker.evaluate({"extra": e}) for e in extras)]


def _link(found: Distribution, site: Path) -> None:
    """Links a distribution's files, which lie in folders and files of their own, into an environment."""
    tops = {file.parts[0] for file in found.files or ()} - {"..", "__pycache__"}
    assert tops, f"{found.name} does not say which files are its"
    for top in tops:
        if not (site / top).exists():
            (site / top).symlink_to(Path(str(found.locate_file(top))).resolve())
