"""Draws yard.pgm: a yard of 30 m x 20 m with stacks of containers, 0.25 m a pixel, as a ROS map_server would save it.

    python3 yard.py > yard.pgm
"""

import sys

PIXELS_PER_METER = 4
(WIDTH, HEIGHT) = (30 * PIXELS_PER_METER, 20 * PIXELS_PER_METER)
(FREE, OCCUPIED) = (254, 0)
FENCE_METERS = 0.5
# West, south, east and north of each stack, meters from the south-western corner.
STACKS = [(6, 4, 10, 8), (6, 12, 10, 16), (14, 4, 18, 8), (14, 12, 18, 16), (22, 8, 26, 14)]


def main():
    pixels = [[OCCUPIED] * WIDTH for _ in range(HEIGHT)]

    def box(west, south, east, north, value):
        for row in range(round(south * PIXELS_PER_METER), round(north * PIXELS_PER_METER)):
            for column in range(round(west * PIXELS_PER_METER), round(east * PIXELS_PER_METER)):
                pixels[HEIGHT - 1 - row][column] = value

    box(FENCE_METERS, FENCE_METERS, 30 - FENCE_METERS, 20 - FENCE_METERS, FREE)
    for stack in STACKS:
        box(*stack, OCCUPIED)
    sys.stdout.buffer.write(b"P5\n%d %d\n255\n" % (WIDTH, HEIGHT))
    sys.stdout.buffer.write(bytes(pixel for row in pixels for pixel in row))


if __name__ == "__main__":
    main()
