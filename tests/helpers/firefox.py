"""A page in Firefox, by its WebDriver BiDi: what it computes, and what it looks like."""

import asyncio
import base64
import json
import re
import subprocess
import time
from contextlib import contextmanager
from io import BytesIO
from itertools import count

from matplotlib.image import imread
from tornado.websocket import websocket_connect

from . import needs

PATIENCE = 60  # s


class Page:
    """A page that was opened; `errors` of its console."""

    def __init__(self, loop, socket):
        self._loop, self._socket, self._numbers, self.errors = loop, socket, count(1), []
        self.call("session.new", capabilities={})
        self.call("session.subscribe", events=["log.entryAdded"])
        self._context = self.call("browsingContext.getTree")["contexts"][0]["context"]

    def call(self, method, **params):
        number = next(self._numbers)

        async def answer():
            await self._socket.write_message(
                json.dumps({"id": number, "method": method, "params": params})
            )
            while True:
                message = json.loads(await self._socket.read_message())
                if (
                    message.get("method") == "log.entryAdded"
                    and message["params"]["level"] == "error"
                ):
                    self.errors.append(message["params"]["text"])
                if message.get("id") == number:
                    return message

        message = self._loop.run_until_complete(asyncio.wait_for(answer(), PATIENCE))
        assert message["type"] == "success", message
        return message["result"]

    def open(self, path, width=1200, height=900):
        size = {"width": width, "height": height}
        self.call("browsingContext.setViewport", context=self._context, viewport=size)
        self.call(
            "browsingContext.navigate", context=self._context, url=path.as_uri(), wait="complete"
        )
        end = time.monotonic() + PATIENCE
        while not self.evaluate("document.body.dataset.ready ?? null"):
            assert time.monotonic() < end, f"{path.name} was never ready: {self.errors}"
            time.sleep(0.05)

    def evaluate(self, expression):
        """The value of an expression, by JSON; promises are waited for."""
        code = f"(async () => JSON.stringify(await ({expression})))()"
        target = {"context": self._context}
        found = self.call("script.evaluate", expression=code, target=target, awaitPromise=True)
        assert found["type"] == "success", found
        return json.loads(found["result"]["value"])

    def picture(self):
        """Pixels (height, width, 3), 0 to 1."""
        data = self.call("browsingContext.captureScreenshot", context=self._context)["data"]
        return imread(BytesIO(base64.b64decode(data)))[..., :3]


@contextmanager
def opened(folder):
    """A Page of a Firefox of its own, whose profile is in the folder."""
    needs.need("firefox")
    command = [
        needs.firefox(),
        "--headless",
        "--remote-debugging-port",
        "0",
        "--profile",
        str(folder),
        "about:blank",
    ]
    with (folder / "said").open("wb") as notes:  # a pipe that nobody empties would stop it
        process = subprocess.Popen(command, stdout=notes, stderr=notes)
    loop = asyncio.new_event_loop()
    try:
        end = time.monotonic() + PATIENCE
        while not (
            found := re.search(r"(ws://[\d.:]+)\s", text := (folder / "said").read_text("utf-8"))
        ):
            assert time.monotonic() < end and process.poll() is None, (
                f"Firefox did not start: {text}"
            )
            time.sleep(0.05)
        address = found[1]

        async def connect():
            return await websocket_connect(address + "/session", max_message_size=2**26)

        async def close():  # in the loop, which tornado asks for
            socket.close()

        socket = loop.run_until_complete(connect())
        yield Page(loop, socket)
        loop.run_until_complete(close())
    finally:
        process.kill()
        process.wait()
        loop.close()
