"""A folder of files served on this machine, and a headless Chromium that opens a page of it."""

import functools
import http.server
import os
import sys
import threading

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *arguments):
        pass

    def end_headers(self):
        # A page that is alone in its process has a clock of 5 microseconds instead of 100.
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        self.send_header("Cross-Origin-Embedder-Policy", "require-corp")
        super().end_headers()


QuietHandler.extensions_map = {**http.server.SimpleHTTPRequestHandler.extensions_map,
                               ".mjs": "text/javascript", ".js": "text/javascript", ".wasm": "application/wasm"}


def serve(folder):
    """The address of the folder; the server ends with the program."""
    handler = functools.partial(QuietHandler, directory=folder)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return f"http://127.0.0.1:{server.server_address[1]}/index.html"


def start_browser(width=1280, height=800):
    options = Options()
    options.add_argument("--headless=new")
    options.add_argument("--enable-unsafe-swiftshader")
    options.add_argument("--hide-scrollbars")
    # No requests of its own.
    for feature in ("background-networking", "component-update", "sync", "quic"):
        options.add_argument(f"--disable-{feature}")
    options.add_argument("--no-first-run")
    options.add_argument(f"--window-size={width},{height}")
    if os.geteuid() == 0:
        options.add_argument("--no-sandbox")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)


def set_width(driver, width, height, scale=1):
    """Of the page itself, also below the least width of windows; `scale`: pixels of the screen for one of the page."""
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                           {"width": width, "height": height, "deviceScaleFactor": scale, "mobile": width < 600})


def wait_for_page(driver, seconds=120):
    driver.set_script_timeout(1200) # a busy machine is no error
    done = driver.execute_async_script(
        "const done = arguments[1], end = performance.now() + 1000 * arguments[0];"
        "const look = () => window.page ? done(true) : performance.now() > end ? done(false) : setTimeout(look, 20);"
        "look();", seconds)
    if not done:
        sys.exit("the page did not load: " + str(driver.get_log("browser")))
