"""Import cycles of modules and of packages, found in the sources; what only type checkers import does not count."""

import ast
from collections.abc import Iterator, Mapping, Set
from pathlib import Path

from tests import ROOT

LEVELS = 2
"""Packages deeper than this count as part of the one around them."""


def graph(folders: Mapping[str, str], *, in_packages: bool) -> dict[str, set[str]]:
    """Return what each module, or each package of the top two levels, imports of the others, in functions, too.

    Args:
        folders: the folder of each top-level package, from the repository's root.
        in_packages: whether packages import, instead of modules. Modules right in a top-level package are left out.
    """
    modules = {name: path for top, folder in folders.items() for name, path in _modules(top, ROOT / folder)}
    packages = {name for name, path in modules.items() if path.name == "__init__.py"}

    def unit(module: str) -> str:
        """Return the node of a module; "" if it has none."""
        if not in_packages:
            return module
        package = ".".join(module.split(".")[:LEVELS])
        return package if package in packages and package not in folders else ""

    found: dict[str, set[str]] = {}
    for module, path in modules.items():
        others = found.setdefault(unit(module), set())
        for name in _imports(ast.parse(path.read_text())):
            others.add(unit(next((part for part in _parts(name) if part in modules), "")))
    return {name: others - {name, ""} for name, others in found.items() if name}


def cycles(imported: Mapping[str, Set[str]]) -> Iterator[set[str]]:
    """Yield the sets of nodes of a graph each of which leads to all others of its set, sorted by their first names."""
    reached = {name: _reached(name, imported) for name in imported}
    seen: set[str] = set()
    for name in sorted(imported):
        if name not in seen and name in reached[name]:
            cycle = {other for other in reached[name] if name in reached.get(other, ())}
            seen |= cycle
            yield cycle


def _reached(start: str, imported: Mapping[str, Set[str]]) -> set[str]:
    found: set[str] = set()
    left = [start]
    while left:
        for name in imported.get(left.pop(), set()) - found:
            found.add(name)
            left.append(name)
    return found


def _modules(top: str, folder: Path) -> Iterator[tuple[str, Path]]:
    for path in sorted(folder.rglob("*.py")):
        if "versions" not in path.parts:  # migrations have no names that can be imported
            parts = path.relative_to(folder).with_suffix("").parts
            yield ".".join((top, *parts)).removesuffix(".__init__"), path


def _imports(node: ast.AST) -> Iterator[str]:
    """Yield the full names of everything that is imported, but for type checkers alone."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import):
            yield from (alias.name for alias in child.names)
        elif isinstance(child, ast.ImportFrom) and child.module:
            yield from (f"{child.module}.{alias.name}" for alias in child.names)
        elif isinstance(child, ast.If) and isinstance(child.test, ast.Name) and child.test.id == "TYPE_CHECKING":
            continue
        else:
            yield from _imports(child)


def _parts(name: str) -> Iterator[str]:
    """Yield a dotted name, and all that begins it, the longest first."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        yield ".".join(parts[:count])
