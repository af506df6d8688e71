"""Draws warehouse.pgm: a hall of 40 m x 24 m with shelves, 0.25 m a pixel, as a ROS map_server would save it.

    python3 warehouse.py > warehouse.pgm
"""

import sys

PIXELS_PER_METER = 4
(WIDTH, HEIGHT) = (40 * PIXELS_PER_METER, 24 * PIXELS_PER_METER)
(FREE, UNKNOWN, OCCUPIED) = (254, 205, 0)


def box(pixels, west, south, east, north, value):
    """Fills a rectangle given in meters from the south-western corner."""
    for row in range(int(south * PIXELS_PER_METER), int(north * PIXELS_PER_METER)):
        for column in range(int(west * PIXELS_PER_METER), int(east * PIXELS_PER_METER)):
            pixels[HEIGHT - 1 - row][column] = value


def main():
    pixels = [[OCCUPIED] * WIDTH for _ in range(HEIGHT)]
    box(pixels, 0.5, 0.5, 39.5, 23.5, FREE)
    for west in range(5, 29, 4):  # six racks with a cross aisle in the middle
        box(pixels, west, 3, west + 1.75, 11, OCCUPIED)
        box(pixels, west, 13, west + 1.75, 21, OCCUPIED)
    box(pixels, 31, 15, 39.5, 15.5, OCCUPIED)  # an office behind a wall with a door
    box(pixels, 31, 15, 31.5, 19, OCCUPIED)
    box(pixels, 31, 21, 31.5, 23.5, OCCUPIED)
    box(pixels, 36, 20, 39.5, 23.5, UNKNOWN)  # a corner of it that the laser never saw
    box(pixels, 34, 4, 37, 7, OCCUPIED)  # packing table
    sys.stdout.buffer.write(b"P5\n%d %d\n255\n" % (WIDTH, HEIGHT))
    sys.stdout.buffer.write(bytes(pixel for row in pixels for pixel in row))


if __name__ == "__main__":
    main()
