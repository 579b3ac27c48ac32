"""How alike pictures of the page are to those of the program `pliant`."""

import base64
import io

import numpy
from PIL import Image
from skimage.metrics import structural_similarity

from browser import set_width

size = (1280, 720)         # of the program's pictures
caption = (slice(0, 110), slice(0, 700)) # its words, which the page's have not: rows and columns from the top left


def take_picture(driver):
    """Of the present frame, drawn at twice the size like the program's."""
    set_width(driver, *size, scale=2)
    data = driver.execute_script("""
        Object.assign(page.canvas.style, { position: 'fixed', inset: '0', width: '100vw', height: '100vh' });
        page.fit();
        page.draw();
        const data = page.canvas.toDataURL('image/png').split(',')[1];
        for (const name of ['position', 'inset', 'width', 'height']) { page.canvas.style[name] = ''; }
        return data;""")
    set_width(driver, 1280, 800)
    return Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB").resize(size, Image.BOX)


def similarity(first, second):
    """Mean structural similarity of two pictures outside of the caption, 1: equal."""
    arrays = [numpy.asarray(picture, dtype=numpy.float64) for picture in (first, second)]
    _, values = structural_similarity(*arrays, channel_axis=2, data_range=255, full=True)
    counted = numpy.ones(values.shape[:2], dtype=bool)
    counted[caption] = False
    return float(values[counted].mean())
