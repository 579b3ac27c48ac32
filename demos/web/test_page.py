"""Runs every scene in headless Chromium. usage: test_page.py FOLDER PROGRAM FLOAT_MATH

Each must load, run 300 frames without errors, have the state hash of the native program (with the functions of
FLOAT_MATH in place of the C library's) and follow a drag by the mouse. The last line of the output counts."""

import json
import os
import subprocess
import sys

from selenium.webdriver.common.action_chains import ActionChains

from browser import serve, set_width, start_browser, wait_for_page

frames = 300
folder, program, float_math = sys.argv[1:]


def native_hash(name):
    output = subprocess.run([program, "run", name, "--frames", str(frames), "--json"], check=True, text=True,
                            capture_output=True, env={**os.environ, "LD_PRELOAD": float_math}).stdout
    return json.loads(output)["state_hash"]


def errors_of(driver):
    return [entry["message"] for entry in driver.get_log("browser") if entry["level"] == "SEVERE"]


def run_scene(driver, name):
    """The hash after all frames, and the words of an alert."""
    return driver.execute_script("""
        page.scene = page.scenes.find((each) => each.name === arguments[0]);
        page.open({ scene: arguments[0] });
        const hash = page.runFrames(arguments[1]), message = document.getElementById('message');
        return [hash, message.hidden ? '' : message.textContent];""", name, frames)


# Places of nodes in the picture, in pixels from its middle, those near the middle first.
find_places = """
    page.open(page.settings);
    const box = page.canvas.getBoundingClientRect(), places = [];
    for (let soft = 0; soft < 3; ++soft) {
        for (let node = 0; node < 40; ++node) {
            let place;
            try { place = page.engine.nodePlace(soft, node, page.pointer.aspect); } catch { break; }
            const { across, up } = place;
            if (Math.abs(across) < 0.8 && Math.abs(up) < 0.7) {
                places.push([Math.round(across * box.width / 2), Math.round(-up * box.height / 2)]);
            }
        }
    }
    return places.sort((a, b) => Math.hypot(...a) - Math.hypot(...b)).slice(0, 12);"""


def drag_moves(driver):
    """A body is held where the mouse is pressed, and ends elsewhere than without the drag."""
    canvas = driver.find_element("id", "canvas")
    undragged = driver.execute_script("page.open(page.settings); return page.runFrames(20);")
    for right, down in driver.execute_script(find_places):
        ActionChains(driver, duration=0).move_to_element_with_offset(canvas, right, down).click_and_hold().perform()
        if driver.execute_script("return page.pointer.action") == "pull":
            ActionChains(driver, duration=0).move_by_offset(40, -60).perform()
            dragged = driver.execute_script("return page.runFrames(20)")
            ActionChains(driver, duration=0).release().perform()
            if dragged != undragged: return True # else a pinned node or a rigid body was met
            driver.execute_script("page.open(page.settings)")
            continue
        ActionChains(driver, duration=0).release().perform()
        driver.execute_script("page.open(page.settings)")
    return False


def main():
    driver = start_browser()
    loaded, equal, dragged, errors = 0, 0, 0, []
    try:
        set_width(driver, 1280, 800)
        driver.get(serve(folder) + "#scene=Cloth&paused=1")
        wait_for_page(driver)
        names = driver.execute_script("return page.scenes.map((scene) => scene.name)")
        for name in names:
            found, message = run_scene(driver, name)
            problems = errors_of(driver) + ([message] if message else [])
            loaded += not problems
            errors += [f"{name}: {problem}" for problem in problems]
            is_equal = found == native_hash(name)
            equal += is_equal
            if not is_equal: errors.append(f"{name}: another hash than the program")
            is_dragged = drag_moves(driver)
            dragged += is_dragged
            if not is_dragged: errors.append(f"{name}: dragging does not move it")
            print(name, found, "equal" if is_equal else "differs", flush=True)
        errors += errors_of(driver)
    finally:
        driver.quit()
    for error in errors: print(error)
    print(f"{loaded} scenes loaded, {equal} hashes equal, {dragged} dragged, {len(errors)} errors")
    return 0 if not errors and loaded == len(names) else 1


sys.exit(main())
