"""Pictures of fields with figures, barrels and posts: what detectors are to find in tests and examples.

Colors are red, green, blue, 0 to 255; places are in pixels from the left and upper edge.
"""

import cv2
import numpy

NAMES = {0: "person", 1: "barrel", 2: "post"}
# Width as a part of the height.
WIDTHS = {0: 0.5, 1: 0.75, 2: 0.3}


def texture(random, rows, columns):
    """Large, middle and small blots."""
    image = numpy.zeros((rows, columns, 3), numpy.float32)
    for parts, strength in [(4, 70), (20, 25), (90, 15)]:
        blots = random.uniform(-1, 1, (parts, parts, 3)).astype(numpy.float32)
        image += strength * cv2.resize(blots, (columns, rows), interpolation=cv2.INTER_CUBIC)
    return image


def paint(image, kind, left, top, right, bottom):
    width, height = right - left, bottom - top

    def box(color, from_left, from_top, to_right, to_bottom):
        corners = (left + width * from_left, top + height * from_top), (left + width * to_right, top + height * to_bottom)
        (a, b), (c, d) = [(round(x), round(y)) for x, y in corners]
        image[b:d, a:c] = color

    if NAMES[kind] == "person":
        radius = 0.16 * height
        center = round(left + width / 2), round(top + radius)
        cv2.circle(image, center, round(radius), (205, 160, 130), -1)
        box((230, 95, 20), 0, 0.32, 1, 0.66)
        box((40, 45, 80), 0.1, 0.66, 0.4, 1)
        box((40, 45, 80), 0.6, 0.66, 0.9, 1)
    elif NAMES[kind] == "post":
        box((230, 10, 10), 0, 0, 1, 1)
    else:
        box((30, 70, 190), 0, 0, 1, 1)
        box((15, 35, 95), 0, 0.2, 1, 0.3)
        box((15, 35, 95), 0, 0.7, 1, 0.8)


def field(random, rows, columns):
    color = numpy.array(random.uniform([60, 70, 35], [140, 140, 100]), numpy.float32)
    return numpy.clip(0.5 * texture(random, rows, columns) + color, 0, 255).astype(numpy.uint8)


def place(kind, left, top, height):
    """Class, left, top, right and lower edge."""
    return kind, left, top, left + height * WIDTHS[kind], top + height
