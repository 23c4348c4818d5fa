"""Drawing of frames: few at once, none for clients that have left, some kept."""

import asyncio
import threading
from functools import partial

import pytest

from arramon_server.errors import Unavailable
from arramon_server.web.watch import frame_queue
from arramon_server.web.watch.frame_queue import ClientLeft, FrameQueue


def stays() -> bool:
    return False


def test_at_most_so_many_are_drawn_at_once_and_each_only_once() -> None:
    async def scenario() -> tuple[int, list[bytes]]:
        queue, drawing, most, lock = FrameQueue(2), 0, 0, threading.Lock()
        both = threading.Barrier(2, timeout=60)

        def draw(number: int) -> bytes:
            nonlocal drawing, most
            with lock:
                drawing += 1
                most = max(most, drawing)
            both.wait()  # until another is drawn, too
            with lock:
                drawing -= 1
            return bytes([number])

        frames = await asyncio.gather(*(queue.frame(n, partial(draw, n), stays) for n in range(8)))
        again = await queue.frame(3, lambda: b"drawn again", stays)
        queue.close()
        return most, [*frames, again]

    assert asyncio.run(scenario()) == (2, [*(bytes([n]) for n in range(8)), b"\3"])


def test_nothing_is_drawn_for_clients_that_have_left() -> None:
    async def scenario() -> None:
        queue = FrameQueue(1)
        with pytest.raises(ClientLeft):
            await queue.frame(1, lambda: pytest.fail("drawn"), lambda: True)
        assert await queue.frame(1, lambda: b"x", stays) == b"x"
        queue.close()

    asyncio.run(scenario())


def test_too_many_requests_are_refused_and_errors_leave_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frame_queue, "MAX_WAITING", 2)

    async def scenario() -> None:
        queue, go_on = FrameQueue(1), threading.Event()

        def wait() -> bytes:
            assert go_on.wait(60)
            return b"x"

        def fail() -> bytes:
            raise ValueError("broken")

        waiting = [asyncio.create_task(queue.frame(n, wait, stays)) for n in range(2)]
        await asyncio.sleep(0)
        with pytest.raises(Unavailable, match="too many frames"):
            await queue.frame(2, wait, stays)
        go_on.set()
        assert await asyncio.gather(*waiting) == [b"x", b"x"]
        with pytest.raises(ValueError, match="broken"):
            await queue.frame(3, fail, stays)
        assert await queue.frame(3, wait, stays) == b"x"
        queue.close()

    asyncio.run(scenario())


def test_old_frames_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frame_queue, "CACHED_FRAMES", 2)

    async def scenario() -> bytes:
        queue = FrameQueue(1)
        for number in range(3):
            await queue.frame(number, lambda: b"first", stays)
        found = await queue.frame(0, lambda: b"second", stays) + await queue.frame(2, lambda: b"second", stays)
        queue.close()
        return found

    assert asyncio.run(scenario()) == b"secondfirst"
