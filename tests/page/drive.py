"""Drives a page of a sweep in Chromium by real mouse and key events, through DevTools' protocol.

Usage: drive.py BROWSER PROFILE_FOLDER PAGE_URL. Needs nothing beyond Python's own library.
"""

import base64
import contextlib
import json
import os
import re
import socket
import struct
import subprocess
import sys
import time
import urllib.request


class Tab:
    """One page, over a WebSocket (RFC 6455)."""

    def __init__(self, address):
        host, port, path = re.fullmatch(r"ws://([^:/]+):(\d+)(/.*)", address).groups()
        self.socket = socket.create_connection((host, int(port)), timeout=30)
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(
            f"GET {path} HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\n"
            f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\n"
            f"Sec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        answer = b""
        while b"\r\n\r\n" not in answer:
            answer += self.socket.recv(1)
        assert answer.startswith(b"HTTP/1.1 101"), answer
        self.count = 0

    def read(self, length):
        data = b""
        while len(data) < length:
            part = self.socket.recv(length - len(data))
            if not part:
                raise ConnectionError("the browser has hung up")
            data += part
        return data

    def receive(self):
        text = b""
        while True:
            first, length = self.read(2)
            if length == 126:
                (length,) = struct.unpack(">H", self.read(2))
            elif length == 127:
                (length,) = struct.unpack(">Q", self.read(8))
            text += self.read(length)
            if first & 0x80:
                return json.loads(text)

    def call(self, method, **parameters):
        """What the browser answers; asked again while a page that loads cannot be asked yet."""
        end = time.monotonic() + 30
        while True:
            answer = self.ask(method, parameters)
            message = answer.get("error", {}).get("message", "")
            if "execution context" not in message or time.monotonic() > end:
                assert "error" not in answer, answer
                return answer["result"]
            time.sleep(0.05)

    def ask(self, method, parameters):
        self.count += 1
        message = {"id": self.count, "method": method, "params": parameters}
        payload = json.dumps(message).encode()
        # A mask of zeros is a mask.
        header = b"\x81" + struct.pack(">BH", 0x80 | 126, len(payload)) + b"\0\0\0\0"
        self.socket.sendall(header + payload)
        while True:
            answer = self.receive()
            if answer.get("id") == self.count:
                return answer

    def evaluate(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def mouse(self, kind, x, y, pressed):
        """`pressed`: whether the left button is down after the event."""
        button = {"button": "left", "buttons": int(pressed), "clickCount": 1}
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **button)

    def drag(self, start, end, y):
        self.mouse("mousePressed", start, y, True)
        for step in range(1, 11):
            self.mouse("mouseMoved", start + (end - start) * step / 10, y, True)
        self.mouse("mouseReleased", end, y, False)

    def click(self, x, y):
        self.mouse("mousePressed", x, y, True)
        self.mouse("mouseReleased", x, y, False)

    def key(self, name, code):
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=name, windowsVirtualKeyCode=code)


SHOWN = "[...document.querySelectorAll('section')].filter(s => !s.hidden).map(s => s.id).join()"
LABEL = "document.querySelector('nav output').textContent"


def place(tab, selector):
    box = "JSON.stringify(document.querySelector(%s).getBoundingClientRect())"
    return json.loads(tab.evaluate(box % json.dumps(selector)))


def expect(tab, view):
    shown, label = tab.evaluate(SHOWN), tab.evaluate(LABEL)
    assert shown == view and label.startswith(view), f"{shown} is shown, “{label}”; not {view}"


def wait(tab):
    """Until the page is there: the first one is blank."""
    end = time.monotonic() + 30
    loaded = "document.readyState === 'complete' && document.querySelector('nav input') !== null"
    while not tab.evaluate(loaded):
        assert time.monotonic() < end, "the page does not load"
        time.sleep(0.05)


def check(tab):
    wait(tab)
    slider = place(tab, "nav input")
    left, right, y = slider["left"], slider["right"], slider["top"] + slider["height"] / 2
    expect(tab, "view_0001")
    tab.drag(left + 8, right - 2, y)
    expect(tab, "view_0004")
    tab.drag(right - 8, left + 2, y)
    expect(tab, "view_0001")
    # A click on the slider's line two thirds along, then a step by the keyboard.
    tab.click(left + (right - left) * 2 / 3, y)
    expect(tab, "view_0003")
    tab.key("ArrowLeft", 37)
    expect(tab, "view_0002")
    # A click on the contact sheet; the slider goes along.
    sheet = place(tab, ".sheet a:nth-child(4) img")
    tab.click(sheet["left"] + sheet["width"] / 2, sheet["top"] + sheet["height"] / 2)
    expect(tab, "view_0004")
    assert tab.evaluate("document.querySelector('nav input').value") == "3"
    assert tab.evaluate("location.hash") == "#view_0004"
    # Arrow keys work wherever the focus is, and the address follows.
    tab.key("ArrowLeft", 37)
    expect(tab, "view_0003")
    assert tab.evaluate("location.hash") == "#view_0003"
    tab.key("Home", 36)
    expect(tab, "view_0001")
    # The luminance under the pointer: in the middle of the picture the lamp's, at its corner the sky's.
    picture = place(tab, "section:not([hidden]) .picture")
    readings = []
    for share in (0.5, 0.01):
        x = picture["left"] + share * picture["width"]
        y = picture["top"] + share * picture["height"]
        tab.mouse("mouseMoved", x, y, False)
        readings.append(tab.evaluate("document.querySelector('section .reading').textContent"))
    found = [re.search(r"x = \d+, y = \d+: (?:≥ )?([0-9.e+-]+) cd/m²$", text) for text in readings]
    assert all(found), readings
    lamp, sky = (float(one[1]) for one in found)
    # The script's sky has 10 cd/m²; a color stands for a few percent.
    assert lamp > 20 and abs(sky / 10 - 1) <= 0.05, readings
    broken = "[...document.images].filter(i => !i.naturalWidth).length"
    assert tab.evaluate(broken) == 0, "pictures that do not show"


@contextlib.contextmanager
def opened(browser, profile, page):
    """The tab of a page in a headless browser."""
    arguments = [
        "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
        "--disable-background-networking", "--disable-component-update", "--disable-sync",
        "--remote-debugging-port=0", "--remote-allow-origins=*", "--window-size=1200,900",
        f"--user-data-dir={profile}", page,
    ]
    process = subprocess.Popen([browser, *arguments], stderr=subprocess.PIPE, text=True)
    try:
        for line in process.stderr:
            found = re.search(r"DevTools listening on ws://([^/]+)/", line)
            if found:
                break
        else:
            raise ConnectionError("the browser does not start")
        with urllib.request.urlopen(f"http://{found[1]}/json/list") as answer:
            tabs = [tab for tab in json.load(answer) if tab["type"] == "page"]
        yield Tab(tabs[0]["webSocketDebuggerUrl"])
    finally:
        process.kill()
        process.wait()


def main(browser, profile, page):
    with opened(browser, profile, page) as tab:
        check(tab)


if __name__ == "__main__":
    main(*sys.argv[1:])
