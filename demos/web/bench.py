"""Compares the speed of the page with that of the program. usage: bench.py FOLDER PROGRAM

One thread each, the program with SSE2: the program, node and headless Chromium in turn. Of each the faster half of the steps
counts, and the shortest of a few runs, as other work on the machine only makes them longer. Then: the time from the address
to the first picture of a scene."""

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


def faster_half(steps):
    """Their mean, ms."""
    half = sorted(steps)[:len(steps) // 2]
    return sum(half) / len(half)


def run_native(scene, options):
    with tempfile.TemporaryDirectory() as place:
        path = f"{place}/steps.csv"
        subprocess.run([program, "run", scene, "--frames", str(frames), "--simd", "portable", "--csv", path, *options],
                       check=True, capture_output=True)
        with open(path) as file: return faster_half([float(row["ms"]) for row in csv.DictReader(file)])


def run_node():
    script = f"{os.path.dirname(os.path.abspath(__file__))}/bench.mjs"
    output = subprocess.run(["node", script, os.path.abspath(folder), page_cases, str(frames)], check=True, text=True,
                            capture_output=True).stdout
    return [faster_half(steps) for steps in json.loads(output)]


def run_chromium(driver):
    cases_steps = driver.execute_script("""
        const frames = arguments[1];
        return JSON.parse(arguments[0]).map(([scene, settings]) => {
            page.engine.open(scene, settings, 1.6);
            return Array.from({ length: frames }, () => {
                page.engine.step();
                return page.engine.figures().stepMs;
            });
        });""", page_cases, frames)
    return [faster_half(steps) for steps in cases_steps]


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
    print(f"ms per step, the faster half of {frames}, the least of {rounds} runs; speed as a share of the program's with SSE2")
    for i, (title, *_) in enumerate(cases):
        figures = [f"{name} {best[name][i]:.3f}" for name in best]
        shares = [f"{name} {best['native'][i] / best[name][i]:.2f}" for name in ("node", "Chromium")]
        print(f"{title}: {', '.join(figures)}; {', '.join(shares)}")
    seconds = [time_first_picture(address + "#scene=Cloth") for _ in range(3)]
    print("first picture after " + ", ".join(f"{each:.2f}" for each in seconds) + " s")


main()
