"""The pictures of the gallery: each scene at the frame that the program's pictures show. usage: pictures.py FOLDER"""

import base64
import os
import sys

from browser import serve, set_width, start_browser, wait_for_page

folder = sys.argv[1]
os.makedirs(f"{folder}/pictures", exist_ok=True)
driver = start_browser()
try:
    set_width(driver, 1280, 800)
    driver.get(serve(folder) + "#scene=Cloth&paused=1")
    wait_for_page(driver)
    for scene in driver.execute_script("return page.scenes"):
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
        with open(f"{folder}/pictures/{scene['name']}.jpg", "wb") as file:
            file.write(base64.b64decode(data))
finally:
    driver.quit()
