"""Runs every scene in headless Chromium. usage: test_page.py FOLDER PROGRAM FLOAT_MATH OUT [SCENE...]

Each must load, run 300 frames without errors, have the state hash of the native program (with the functions of
FLOAT_MATH in place of the C library's) and a picture like its own, and follow a drag by the mouse. Then btSoftBody runs
beside Pliant, and gravity, the links and what is shown are changed. Pictures go to OUT. The last line counts."""

import json
import os
import subprocess
import sys

from PIL import Image
from selenium.webdriver.common.action_chains import ActionChains

from browser import serve, set_width, start_browser, wait_for_page
from compare_pictures import similarity, take_picture

frames = 300
# Beside each scene with its own solver.
other_solvers = [(scene, solver) for solver in ("implicit", "xpbd") for scene in ("Cloth", "Bunny", "Ropes")]
least_similarity = 0.9
folder, program, float_math, out, *wanted = sys.argv[1:]


def native_hash(name, *options):
    output = subprocess.run([program, "run", name, "--frames", str(frames), "--json", *options], check=True, text=True,
                            capture_output=True, env={**os.environ, "LD_PRELOAD": float_math}).stdout
    return json.loads(output)["state_hash"]


def errors_of(driver):
    return [entry["message"] for entry in driver.get_log("browser") if entry["level"] == "SEVERE"]


def is_left_out(problem):
    """About a picture of the gallery that is not drawn, since its scene is not wanted."""
    return wanted and "/pictures/" in problem and not any(f"/pictures/{name}.jpg" in problem for name in wanted)


def run_scene(driver, name, solver=""):
    """The hash after all frames, and the words of an alert."""
    return driver.execute_script("""
        page.scene = page.scenes.find((each) => each.name === arguments[0]);
        page.open({ scene: arguments[0], solver: arguments[1] });
        const hash = page.runFrames(arguments[2]), message = document.getElementById('message');
        return [hash, message.hidden ? '' : message.textContent];""", name, solver, frames)


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


# Each setting changes what it should; what does not is told.
try_settings = """
    const problems = [], expect = (is, what) => { if (!is) { problems.push(what); } };
    const find = (id) => document.getElementById(id);
    const show = (name, settings) => {
        page.scene = page.scenes.find((each) => each.name === name);
        page.open({ scene: name, ...settings });
    };
    const choose = (id, value) => {
        const element = find(id);
        if (element.type === 'checkbox') { element.checked = value; } else { element.value = value; }
        element.dispatchEvent(new Event('input', { bubbles: true }));
        element.dispatchEvent(new Event('change', { bubbles: true }));
    };
    show('Cloth', {});
    const alone = page.runFrames(60);
    choose('beside', true);
    expect(page.views.length === 2 && location.hash.includes('beside=1'), 'btSoftBody is not beside it');
    expect(page.runFrames(60) === alone, 'Pliant runs otherwise beside btSoftBody');
    expect(page.engine.figures(1).speed > 0, 'btSoftBody does not move');
    expect([...find('titles').children].map((each) => each.textContent).join() === 'Pliant,btSoftBody', 'no titles');
    choose('gravity', 3);
    page.runFrames(60);
    expect(location.hash.includes('gravity=3'), 'the link has no gravity');
    show('FoldingCloth', { gravity: 0 });
    page.runFrames(60);
    expect(page.engine.figures().speed < 1e-6, 'it falls without gravity');
    expect(!find('self').hidden && !find('columns').hidden, 'no choice of self-collision and resolution');
    choose('columns', 16);
    expect(page.engine.figures().nodes === 256, 'the resolution stays');
    for (const kind of ['off', 'nodes', 'grids', 'faces']) {
        choose('self', kind);
        expect(page.facts.self_collision === kind, 'self-collision of ' + kind);
    }
    show('ClusterCombine', {});
    const materials = () => page.engine.frame(0, 1, 600).materials;
    const usual = materials().length;
    page.runFrames(100);
    for (const name of ['contacts', 'clusters', 'wireframe']) {
        const box = document.querySelector(`#looks [name=${name}]`), before = materials();
        box.click();
        const after = materials();
        expect(after.length > before.length || after.some((each) => each.hollow) !== before.some((each) => each.hollow),
            'nothing to see of ' + name);
        box.click();
    }
    show('Bunny', { solver: 'xpbd', substeps: 4, iterations: 3 });
    expect(page.facts.solver === 'xpbd' && page.facts.substeps === 4 && page.facts.iterations === 3, 'settings');
    return problems;"""

# Those of the gallery that are on the screen; the addresses of what cannot be shown.
await_pictures = """
    const isOnScreen = (image) => image.getClientRects().length > 0 && image.getBoundingClientRect().top < innerHeight;
    const pictures = [...document.images].filter(isOnScreen);
    Promise.all(pictures.map((image) => image.decode().then(() => [], () => [image.src]))).then((failed) => {
        requestAnimationFrame(() => arguments[0](failed.flat()));
    });"""


def main():
    os.makedirs(out, exist_ok=True)
    driver = start_browser()
    loaded, equal, alike, dragged, errors = 0, 0, 0, 0, []
    try:
        set_width(driver, 1280, 800)
        site = serve(folder)
        driver.get(site + "#scene=Cloth&paused=1")
        wait_for_page(driver)
        names = driver.execute_script("return page.scenes.map((scene) => scene.name)")
        unknown = set(wanted) - set(names)
        if unknown: sys.exit(f"no scenes of the page: {', '.join(sorted(unknown))}")
        names = wanted or names
        for name in names:
            found, message = run_scene(driver, name)
            problems = errors_of(driver) + ([message] if message else [])
            loaded += not problems
            errors += [f"{name}: {problem}" for problem in problems]
            picture = take_picture(driver)
            picture.save(f"{out}/{name}-page.png")
            path = f"{out}/{name}-program.png"
            is_equal = found == native_hash(name, "--png", path)
            equal += is_equal
            if not is_equal: errors.append(f"{name}: another hash than the program")
            likeness = similarity(picture, Image.open(path).convert("RGB"))
            alike += likeness >= least_similarity
            if likeness < least_similarity: errors.append(f"{name}: its picture is another one")
            is_dragged = drag_moves(driver)
            dragged += is_dragged
            if not is_dragged: errors.append(f"{name}: dragging does not move it")
            print(name, found, "equal" if is_equal else "differs", f"likeness {likeness:.3f}", flush=True)
        for name, solver in other_solvers:
            found, message = run_scene(driver, name, solver)
            is_equal = not message and found == native_hash(name, "--solver", solver)
            if not is_equal: errors.append(f"{name}, {solver}: another hash than the program {message}")
            print(name, solver, found, "equal" if is_equal else "differs", flush=True)
        errors += driver.execute_script(try_settings) + errors_of(driver)
        for width, height in [(1280, 800), (390, 844)]:
            set_width(driver, width, height)
            for title, address in [("gallery", ""), ("scene", "#scene=Flag"), ("beside", "#scene=Cloth&beside=1")]:
                driver.get("about:blank")
                driver.get(site + address)
                wait_for_page(driver)
                if address: driver.execute_script("page.runFrames(90)")
                if driver.execute_script("return document.documentElement.scrollWidth > innerWidth"):
                    errors.append(f"{title} is wider than {width} pixels")
                errors += driver.execute_async_script(await_pictures)
                driver.save_screenshot(f"{out}/{title}-{width}.png")
        errors += errors_of(driver)
        errors = [error for error in errors if not is_left_out(error)]
    finally:
        driver.quit()
    for error in errors: print(error)
    print(f"{loaded} scenes loaded, {equal} hashes equal, {alike} pictures alike, {dragged} dragged, "
          f"{len(errors)} errors")
    return 0 if not errors and loaded == len(names) else 1


sys.exit(main())
