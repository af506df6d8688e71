"""Writes a base map with the `pmtiles` package: green tiles around a place, and a red disc on it.

Usage: basemap.py FILE LATITUDE LONGITUDE
"""

import io
import math
import sys

from PIL import Image, ImageDraw
from pmtiles.tile import Compression, TileType, zxy_to_tileid
from pmtiles.writer import write

ZOOMS = range(10, 17)
SIDE = 256
DISC_PIXELS = 6


def place(latitude, longitude, zoom):
    """Column and row of a place among the tiles of a level, with fractions."""
    north = math.asinh(math.tan(math.radians(latitude)))
    return (longitude + 180) / 360 * 2**zoom, (1 - north / math.pi) / 2 * 2**zoom


def tile(column, row, center):
    image = Image.new("RGB", (SIDE, SIDE), (120, 170, 90))
    x, y = (SIDE * (at - corner) for at, corner in zip(center, (column, row)))
    ImageDraw.Draw(image).ellipse([x - DISC_PIXELS, y - DISC_PIXELS, x + DISC_PIXELS, y + DISC_PIXELS], (255, 0, 0))
    png = io.BytesIO()
    image.save(png, "PNG")
    return png.getvalue()


def main(file, latitude, longitude):
    with write(file) as archive:
        for zoom in ZOOMS:
            center = place(latitude, longitude, zoom)
            reach = 6
            near = [range(max(0, int(at) - reach), min(2**zoom, int(at) + reach + 1)) for at in center]
            ids = sorted((zxy_to_tileid(zoom, column, row), column, row) for column in near[0] for row in near[1])
            for number, column, row in ids:
                archive.write_tile(number, tile(column, row, center))
        header = {
            "tile_type": TileType.PNG,
            "tile_compression": Compression.NONE,
            "min_lon_e7": int((longitude - 0.5) * 1e7),
            "min_lat_e7": int((latitude - 0.5) * 1e7),
            "max_lon_e7": int((longitude + 0.5) * 1e7),
            "max_lat_e7": int((latitude + 0.5) * 1e7),
            "center_zoom": ZOOMS[0],
            "center_lon_e7": int(longitude * 1e7),
            "center_lat_e7": int(latitude * 1e7),
        }
        archive.finalize(header, {"attribution": "<b>drawn</b> by a test"})


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), float(sys.argv[3]))
