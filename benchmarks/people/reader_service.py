"""The background process of a machine reader: it keeps the page open, and takes keys from a socket in its folder."""

import asyncio
import contextlib
import secrets
from argparse import Namespace
from pathlib import Path
from typing import Any

from benchmarks.people.page_connection import ANSWER_SECONDS, PageConnection
from benchmarks.people.page_state import say, state_text
from benchmarks.people.reader_folder import OVER, PREFIX, RUN, SOCKET, ReaderError, is_served, read_run, write_run
from benchmarks.people.sheet import write_sheet


def serve(options: Namespace) -> str:
    """Play a run until it is over, and return why it is.

    Raises:
        ReaderError: if the folder belongs to another run, or another process serves it.
    """
    folder: Path = options.folder
    for name in ("frames", "sheets"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    if is_served(folder):
        raise ReaderError(f"another process serves {folder}; press its keys, or name another folder")
    settings = _settings(options)
    with contextlib.chdir(folder):  # Addresses of Unix sockets are short.
        for name in (SOCKET, OVER):
            Path(name).unlink(missing_ok=True)
        try:
            return asyncio.run(_serve(settings, folder.resolve()))
        finally:
            Path(SOCKET).unlink(missing_ok=True)


async def _serve(settings: dict[str, Any], folder: Path) -> str:
    hello = {"type": "hello", "player": settings["player"], "token": "", "size": settings["size"]}
    what = {"run": settings["run"]} if settings["run"] else {"new": settings["new"]}
    page = PageConnection(settings["site"], hello, what, folder / "frames")
    one_at_a_time = asyncio.Lock()

    async def take(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        letters = (await reader.readline()).decode().strip()
        async with one_at_a_time:
            text = await _answer(page, letters, folder)
            with contextlib.suppress(ConnectionError):
                writer.write(text.encode())
                await writer.drain()
            writer.close()

    async with asyncio.TaskGroup() as tasks, await asyncio.start_unix_server(take, SOCKET):
        playing = tasks.create_task(page.play())
        await page.first()
        if page.run:
            write_run(folder, {**settings, "run": page.run})
        await playing
        (folder / OVER).write_text(page.over + "\n", encoding="utf-8")
        async with one_at_a_time:  # The last key has been answered.
            pass
    return page.over


async def _answer(page: PageConnection, letters: str, folder: Path) -> str:
    try:
        async with asyncio.timeout(ANSWER_SECONDS):
            await page.first()
    except TimeoutError:
        return say("lost") + "\n"
    lines, passed = await page.press(letters)
    if page.over:
        return "\n".join([*lines, page.over, ""])
    assert page.shown is not None
    sheet = folder / "sheets" / page.shown.frame.with_suffix(".png").name
    write_sheet(sheet, [(caption, shown.frame) for caption, shown in passed or [("now", page.shown)]])
    lines.append(f"Frames of these keys, the last one as it is now: {sheet}" if passed else f"Frame now: {sheet}")
    return "\n".join([*lines, state_text(page.shown), ""])


def _settings(options: Namespace) -> dict[str, Any]:
    """Return what the folder plays: as written there, or else new from the options.

    Raises:
        ReaderError: if what is written there differs from the options.
    """
    new = {
        "split": options.split,
        "language": options.language,
        "episodes": options.episodes,
        "participant": f"{PREFIX}{options.name}",
        "earlier": [read_run(folder)["run"] for folder in options.earlier],
    }
    asked = {"site": options.site.rstrip("/"), "size": options.size, "new": new}
    if not (options.folder / RUN).exists():
        settings = {**asked, "player": secrets.token_hex(8), "run": ""}
        write_run(options.folder, settings)
        return settings
    found = read_run(options.folder)
    differing = [name for name, value in asked.items() if found[name] != value]
    if differing:
        what = "; ".join(f"{name} is {found[name]}, expected {asked[name]}" for name in differing)
        raise ReaderError(f"{options.folder} plays another run: {what}. Name another folder, or give the same options")
    return found
