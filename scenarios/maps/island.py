"""Writes the outline of one small country of a TopoJSON file as GeoJSON (RFC 7946).

    python3 island.py countries-10m.json Jersey > jersey.geojson

See README.md for where the TopoJSON file comes from.
"""

import json
import sys


def decode_arcs(topology):
    """Arcs are chains of integer steps; scale and translation turn them into degrees."""
    (scale_x, scale_y) = topology["transform"]["scale"]
    (west, south) = topology["transform"]["translate"]
    arcs = []
    for steps in topology["arcs"]:
        (x, y) = (0, 0)
        points = []
        for (step_x, step_y) in steps:
            (x, y) = (x + step_x, y + step_y)
            points.append([round(x * scale_x + west, 6), round(y * scale_y + south, 6)])
        arcs.append(points)
    return arcs


def join_ring(indices, arcs):
    """Arcs share their end points; a negative index means the arc backwards."""
    ring = []
    for index in indices:
        points = arcs[index] if index >= 0 else arcs[~index][::-1]
        ring += points[1:] if ring else points
    return ring


def area2(ring):
    """Twice the signed area: positive is counterclockwise."""
    return sum(a[0] * b[1] - b[0] * a[1] for (a, b) in zip(ring, ring[1:]))


def turn(ring, counterclockwise):
    """RFC 7946 wants outer rings counterclockwise and holes clockwise."""
    return ring if (area2(ring) > 0) == counterclockwise else ring[::-1]


def main(path, name):
    with open(path, encoding="utf-8") as file:
        topology = json.load(file)
    arcs = decode_arcs(topology)
    countries = topology["objects"]["countries"]["geometries"]
    country = next(country for country in countries if country["properties"]["name"] == name)
    polygons = country["arcs"] if country["type"] == "MultiPolygon" else [country["arcs"]]
    coordinates = [
        [turn(join_ring(ring, arcs), number == 0) for (number, ring) in enumerate(polygon)]
        for polygon in polygons
    ]
    single = len(coordinates) == 1
    feature = {
        "type": "Feature",
        "properties": {"name": name, "source": "Natural Earth 1:10m, public domain"},
        "geometry": {
            "type": "Polygon" if single else "MultiPolygon",
            "coordinates": coordinates[0] if single else coordinates,
        },
    }
    print(json.dumps(feature))


if __name__ == "__main__":
    main(*sys.argv[1:])
