"""The manual in headless Chromium: test_site.py SITE [SHOTS]

From a server and from the disk: the search finds pli_body_enable_tethers and leads to it, equations are drawn, nothing
is asked for outside of the folder, and no page is wider than a desk's or a phone's screen. SHOTS gets pictures."""

import functools
import http.server
import json
import re
import sys
import threading
import time
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

SHOWN = ("index.html", "guide.html", "manual/choosing.html", "manual/method_xpbd.html", "reference/tether.html",
         "reference/xpbd.html", "bullet_migration.html", "solvers.html", "costs.html", "manual/troubleshooting.html")


class Handler(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


def serve(site):
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=str(site)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return f"http://127.0.0.1:{server.server_port}/"


def start():
    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--window-size=1280,900"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(options=options)


def check_requests(driver, base):
    for line in driver.get_log("performance"):
        message = json.loads(line["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            address = message["params"]["request"]["url"]
            if not address.startswith((base, "data:", "blob:", "chrome", "about:")):
                sys.exit(f"the manual asked for {address}")
    errors = [entry["message"] for entry in driver.get_log("browser") if entry["level"] == "SEVERE"]
    if errors:
        sys.exit(f"errors of the console: {errors}")


def search(driver, base, query, wanted):
    driver.get(base + "index.html")
    driver.set_window_size(1280, 900)
    field = WebDriverWait(driver, 20).until(lambda d: d.find_element(By.CSS_SELECTOR, "input.md-search__input"))
    driver.execute_script("document.getElementById('__search').checked = true;"
                          "document.getElementById('__search').dispatchEvent(new Event('change'))")
    time.sleep(0.5)
    field.click()
    field.send_keys(query)
    addresses = []
    for _ in range(100):  # results come while the query is typed
        links = driver.execute_script(
            "return [...document.querySelectorAll('a.md-search-result__link')].map(a => a.href)")
        addresses = [re.sub(r"\?[^#]*", "", link) for link in links]
        if any(wanted in address for address in addresses[:5]):
            break
        time.sleep(0.1)
    else:
        sys.exit(f"{query} leads to {addresses[:5]}")
    driver.get(next(address for address in addresses if wanted in address))
    name = wanted.partition("#")[2]
    if name and driver.execute_script("return document.getElementById(arguments[0])", name) is None:
        sys.exit(f"{wanted} is not there")


def check_pages(driver, base, site, shots):
    pages = sorted(path.relative_to(site).as_posix() for path in site.rglob("*.html"))
    for width, height in ((1280, 900), (390, 844)):
        # A window is not made narrower than 500 pixels, the page in it is.
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                               {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500})
        for page in pages:
            driver.get(base + page)
            wide = driver.execute_script("return document.documentElement.scrollWidth")
            if wide > width:
                sys.exit(f"{page} is {wide} pixels wide on a screen of {width}")
            if driver.execute_script("return [...document.images].some(i => i.complete && i.naturalWidth === 0)"):
                sys.exit(f"{page} has a picture that is not there")
            if driver.execute_script("return document.querySelectorAll('.katex-error').length"):
                sys.exit(f"{page} has an equation that cannot be drawn")
            if page.startswith("manual/method_") and \
                    not driver.execute_script("return document.querySelectorAll('.katex').length"):
                sys.exit(f"{page} shows no equation")
            if shots and page in SHOWN:
                time.sleep(0.3)
                driver.save_screenshot(str(shots / f"{page.replace('/', '_')}_{width}.png"))
    driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    return len(pages)


def main():
    site = Path(sys.argv[1]).resolve()
    shots = Path(sys.argv[2]).resolve() if len(sys.argv) > 2 else None
    if shots:
        shots.mkdir(parents=True, exist_ok=True)
    driver = start()
    try:
        for base in (serve(site), site.as_uri() + "/"):
            search(driver, base, "pli_body_enable_tethers", "reference/tether.html#pli_body_enable_tethers")
            search(driver, base, "tethers", "reference/tether.html")
            check_requests(driver, base)
            if base.startswith("http"):
                print(f"{check_pages(driver, base, site, shots)} pages looked at")
                check_requests(driver, base)
        print("the search works from a server and from the disk")
    finally:
        driver.quit()


main()
