"""The pictures of the gallery that are missing: each scene, or those named, at the frame that the program's pictures
show. usage: pictures.py FOLDER [SCENE...]"""

import base64
import concurrent.futures
import os
import sys
from pathlib import Path

from browser import serve, set_width, start_browser, wait_for_page

folder, names = sys.argv[1], sys.argv[2:]
pictures = Path(folder, "pictures")


def draw(driver, scene):
    data = driver.execute_script("""
        const [scene] = arguments;
        page.scene = page.scenes.find((each) => each.name === scene.name);
        page.open({ scene: scene.name });
        page.runFrames(scene.picture_frame || 300);
        page.engine.showAll(1.6);
        page.draw();
        const small = document.createElement('canvas');
        small.width = 480;
        small.height = 300;
        const from = page.canvas, width = Math.min(from.width, 1.6 * from.height), height = width / 1.6;
        small.getContext('2d').drawImage(from, (from.width - width) / 2, (from.height - height) / 2, width, height,
                                         0, 0, 480, 300);
        return small.toDataURL('image/jpeg', 0.82).split(',')[1];""", scene)
    unfinished = pictures / f"{scene['name']}.unfinished"
    unfinished.write_bytes(base64.b64decode(data))
    unfinished.rename(unfinished.with_suffix(".jpg"))


def draw_scenes(address, taken):
    """What no other browser has taken; the last ones are those that take longest."""
    driver = start_browser()
    try:
        set_width(driver, 1280, 800)
        driver.get(address + "#scene=Cloth&paused=1")
        wait_for_page(driver)
        for scene in reversed(driver.execute_script("return page.scenes")):
            is_wanted = not names or scene["name"] in names
            if not is_wanted or scene["name"] in taken: continue
            taken.add(scene["name"])
            draw(driver, scene)
    finally:
        driver.quit()


pictures.mkdir(exist_ok=True)
browsers, address, taken = min(os.cpu_count(), 4), serve(folder), {picture.stem for picture in pictures.glob("*.jpg")}
with concurrent.futures.ThreadPoolExecutor(browsers) as pool:
    for drawing in [pool.submit(draw_scenes, address, taken) for _ in range(browsers)]:
        drawing.result()
if not names: (pictures / "complete").touch()
