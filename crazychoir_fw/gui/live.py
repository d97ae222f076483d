"""What browsers receive while the drones fly: a frame 15 times a second as numbers, and words twice a second.

Frames are made once for all browsers. A slow browser misses frames, and delays no other.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
from collections.abc import Awaitable, Callable
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from crazychoir_fw.gui.feed import FRAME_S, Feed

WORDS_S = 0.5
_MAX_WATCHED = 64  # variables of one browser
_MAX_WORDS = 50_000  # bytes of a message of a browser


class Live:
    """Tells all browsers; runs in the loop of the server."""

    def __init__(self, feed: Feed, words: Callable[[], Awaitable[dict[str, Any]]]) -> None:
        """Tell a flight; `words` returns what changes slowly."""
        self._feed = feed
        self._words = words
        self._browsers: set[_Browser] = set()
        self._task: asyncio.Task[None] | None = None

    @property
    def count(self) -> int:
        """How many browsers watch."""
        return len(self._browsers)

    async def serve(self, socket: WebSocket) -> None:
        """Tell one browser, for as long as it listens."""
        await socket.accept()
        browser = _Browser(socket, self._feed)
        self._browsers.add(browser)
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._tell_all())
        sending = asyncio.create_task(browser.send())
        try:
            await browser.listen()
        except (WebSocketDisconnect, RuntimeError):
            pass
        finally:
            self._browsers.discard(browser)
            self._feed.watched.pop(browser, None)
            sending.cancel()
            with contextlib.suppress(asyncio.CancelledError, Exception):
                await sending

    async def _tell_all(self) -> None:
        shown, next_words = -1, 0.0
        loop = asyncio.get_running_loop()
        while self._browsers:
            frame = self._feed.frame
            if frame is not None and frame.number != shown:
                shown = frame.number
                data = frame.packed()
                for browser in self._browsers:
                    browser.offer(data)
            if loop.time() >= next_words:
                next_words = loop.time() + WORDS_S
                words = {**await self._words(), "browsers": self.count}
                for browser in self._browsers:
                    browser.tell(words)
            else:
                for browser in self._browsers:
                    browser.plot()
            await asyncio.sleep(FRAME_S)


class _Browser:
    """One browser: the latest frame for it, and words that it has not heard."""

    def __init__(self, socket: WebSocket, feed: Feed) -> None:
        self._socket = socket
        self._feed = feed
        self._frame: bytes | None = None
        self._words: list[str] = []
        self._wake = asyncio.Event()
        self._heard = 0
        self._plotted = -math.inf

    def offer(self, frame: bytes) -> None:
        """Have the latest frame for it."""
        self._frame = frame
        self._wake.set()

    def tell(self, words: dict[str, Any]) -> None:
        """Say something that it must hear, if it listens at all."""
        if len(self._words) > 20:
            return
        lines = self._feed.lines_since(self._heard)
        if lines:
            self._heard = lines[-1]["number"]
        self._words.append(json.dumps({**words, "lines": lines, **self._samples()}))
        self._wake.set()

    def plot(self) -> None:
        """Send samples of the variables that it watches."""
        samples = self._samples()
        if samples and len(self._words) < 20:
            self._words.append(json.dumps(samples))
            self._wake.set()

    def _samples(self) -> dict[str, Any]:
        chosen = self._feed.watched.get(self)
        if not chosen:
            return {}
        times, rows = [], []
        for time, values in list(self._feed.plotted):
            if time > self._plotted:
                times.append(round(time, 3))
                row = [values.get(key, math.nan) for key in chosen]
                rows.append([value if math.isfinite(value) else None for value in row])
        if not times:
            # time may have gone back by a rewind
            newest = self._feed.plotted[-1][0] if self._feed.plotted else -math.inf
            if newest < self._plotted - 0.2:
                self._plotted = -math.inf
            return {}
        self._plotted = times[-1]
        return {"plot": {"times": times, "rows": rows, "names": [f"{d}:{name}" for d, name in chosen]}}

    async def send(self) -> None:
        """Send what there is, until the browser has gone."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            frame, self._frame = self._frame, None
            words, self._words = self._words, []
            for text in words:
                await self._socket.send_text(text)
            if frame is not None:
                await self._socket.send_bytes(frame)

    async def listen(self) -> None:
        """Hear which variables it wants to plot: ``{"watch": [[drone, name], ...]}``. Anything else is ignored."""
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            text = message.get("text")
            if not isinstance(text, str) or len(text) > _MAX_WORDS:
                continue
            with contextlib.suppress(ValueError, RecursionError):
                self._take(json.loads(text))

    def _take(self, wish: Any) -> None:
        if not isinstance(wish, dict) or not isinstance(wish.get("watch"), list):
            return
        count, chosen = len(self._feed.names), []
        for entry in wish["watch"][:_MAX_WATCHED]:
            is_pair = isinstance(entry, list) and len(entry) == 2 and isinstance(entry[1], str)
            if is_pair and type(entry[0]) is int and 0 <= entry[0] < count and len(entry[1]) <= 64:
                chosen.append((entry[0], entry[1]))
        self._feed.watched[self] = tuple(chosen)
        self._plotted = -math.inf
