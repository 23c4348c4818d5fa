"""Fresh virtual environments with this project's wheels and their dependencies."""

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


class Environment:
    """A virtual environment that sees nothing of the source tree.

    What the wheels require is linked in from the environment of the tests, as a download would take minutes: that and
    nothing else of it, so that a requirement that was not declared is missing here too.

    Args:
        folder: of the new environment.
        wheels: to install.
        more: further requirements, such as "numba".
    """

    def __init__(self, folder: Path, wheels: Sequence[Path], more: Sequence[str] = ()) -> None:
        venv.create(folder, symlinks=True)
        self.folder = folder
        (self.site,) = folder.glob("lib/python3*/site-packages")
        self._pip("install", "--quiet", "--no-compile", "--no-index", "--no-deps", *map(str, wheels))
        self.ours = {each.name for each in distributions(path=[str(self.site)])}
        for required in self._required(more):
            _link(required, self.site)
        self._pip("check")

    def run(self, command: str, cwd: Path, **variables: str) -> "subprocess.CompletedProcess[str]":
        """Runs one of the environment's programs to its end, with the arguments behind it as in a shell."""
        given, environment = self.command(command), self.variables(**variables)
        return subprocess.run(given, cwd=cwd, env=environment, capture_output=True, text=True, timeout=240)

    def command(self, command: str) -> list[str]:
        program, *arguments = shlex.split(command)
        return [str(self.folder / "bin" / program), *arguments]

    def variables(self, **more: str) -> dict[str, str]:
        """The environment variables of a stranger's shell, and more."""
        return {"PATH": os.environ["PATH"], "HOME": str(self.folder), "LANG": "C.UTF-8", **more}

    def _pip(self, *arguments: str) -> None:
        command = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--python", str(self.folder), *arguments]
        # Somewhere else: in the source tree its own metadata would be found.
        where, variables = self.folder, self.variables()
        done = subprocess.run(command, cwd=where, env=variables, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stdout + done.stderr

    def _required(self, more: Sequence[str]) -> Iterator[Distribution]:
        """All that the installed wheels require, and more, and what that requires."""
        seen = {(canonicalize_name(name), "") for name in self.ours}
        waiting = [each for ours in distributions(path=[str(self.site)]) for each in _requirements(ours, ("",))]
        waiting += map(Requirement, more)
        while waiting:
            requirement = waiting.pop()
            name = canonicalize_name(requirement.name)
            new = {(name, extra) for extra in ("", *requirement.extras)} - seen
            if new:
                seen |= new
                found = distribution(requirement.name)
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
