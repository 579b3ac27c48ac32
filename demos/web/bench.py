"""Compares the speed of the page with that of the program. usage: bench.py FOLDER PROGRAM

One thread each, the program with SSE2: steps of the program, of node and of headless Chromium in turn, and of each the
shortest time of a few runs, as other work on the machine only makes it longer. Then: the time from the address to the
first picture of a scene."""

import csv
import json
import os
import subprocess
import sys
import tempfile

from browser import serve, set_width, start_browser, wait_for_page

rounds, frames = 5, 120
folder, program = sys.argv[1:]
# What is shown, scene, settings of the page, options of the program.
cases = [("bunny, links by colours", "Bunny", {}, []),
         ("sheet of 64 x 64 nodes", "FoldingCloth", {"columns": 64, "self": "off"},
          ["--resolution", "64", "--self-collision", "off"]),
         ("TetraBunny", "TetraBunny", {}, [])]
page_cases = json.dumps([[scene, settings] for _, scene, settings, _ in cases])


def run_native(scene, options):
    with tempfile.TemporaryDirectory() as place:
        path = f"{place}/steps.csv"
        subprocess.run([program, "run", scene, "--frames", str(frames), "--simd", "portable", "--csv", path, *options],
                       check=True, capture_output=True)
        with open(path) as file: return sum(float(row["ms"]) for row in csv.DictReader(file))


def run_node():
    script = f"{os.path.dirname(os.path.abspath(__file__))}/bench.mjs"
    return json.loads(subprocess.run(["node", script, os.path.abspath(folder), page_cases, str(frames)], check=True,
                                     text=True, capture_output=True).stdout)


def run_chromium(driver):
    return driver.execute_script("""
        return JSON.parse(arguments[0]).map(([scene, settings]) => {
            page.engine.open(scene, settings, 1.6);
            let sum = 0;
            for (let i = 0; i < arguments[1]; ++i) {
                page.engine.step();
                sum += page.engine.figures().stepMs;
            }
            return sum;
        });""", page_cases, frames)


def time_first_picture(address):
    """From the start of the navigation, in a new browser with nothing in its cache, s."""
    driver = start_browser()
    try:
        set_width(driver, 1280, 800)
        driver.get(address)
        wait_for_page(driver)
        return driver.execute_script("return page.firstPicture") / 1000
    finally:
        driver.quit()


def main():
    address = serve(folder)
    driver = start_browser()
    best = {}
    try:
        driver.get(address + "#scene=Cloth&paused=1")
        wait_for_page(driver)
        for _ in range(rounds):
            for name, times in [("native", [run_native(scene, options) for _, scene, _, options in cases]),
                                ("node", run_node()), ("Chromium", run_chromium(driver))]:
                best[name] = [min(pair) for pair in zip(times, best.get(name, times))]
    finally:
        driver.quit()
    print(f"ms per step, mean of {frames}, the least of {rounds} runs; speed as a share of the program's with SSE2")
    for i, (title, *_) in enumerate(cases):
        figures = [f"{name} {best[name][i] / frames:.3f}" for name in best]
        shares = [f"{name} {best['native'][i] / best[name][i]:.2f}" for name in ("node", "Chromium")]
        print(f"{title}: {', '.join(figures)}; {', '.join(shares)}")
    seconds = [time_first_picture(address + "#scene=Cloth") for _ in range(3)]
    print("first picture after " + ", ".join(f"{each:.2f}" for each in seconds) + " s")


main()
