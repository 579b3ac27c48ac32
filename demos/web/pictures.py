"""The pictures of the gallery: each scene at the frame that the program's pictures show. usage: pictures.py FOLDER"""

import base64
import concurrent.futures
import os
import shutil
import sys

from browser import serve, set_width, start_browser, wait_for_page

folder = sys.argv[1]
pictures = f"{folder}/pictures"
unfinished = f"{pictures}.unfinished"


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
    with open(f"{unfinished}/{scene['name']}.jpg", "wb") as file:
        file.write(base64.b64decode(data))


def draw_scenes(address, taken):
    """What no other browser has taken; the last ones are those that take longest."""
    driver = start_browser()
    try:
        set_width(driver, 1280, 800)
        driver.get(address + "#scene=Cloth&paused=1")
        wait_for_page(driver)
        for scene in reversed(driver.execute_script("return page.scenes")):
            if scene["name"] in taken: continue
            taken.add(scene["name"])
            draw(driver, scene)
    finally:
        driver.quit()


shutil.rmtree(unfinished, ignore_errors=True)
os.makedirs(unfinished)
browsers, address, taken = min(os.cpu_count(), 4), serve(folder), set()
with concurrent.futures.ThreadPoolExecutor(browsers) as pool:
    for drawing in [pool.submit(draw_scenes, address, taken) for _ in range(browsers)]:
        drawing.result()
os.rename(unfinished, pictures)
