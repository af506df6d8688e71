"""Reads exported files with libraries that are not ours, and prints as JSON what each of them saw.

Usage: read_export.py GEOJSON KML GPX

KML is also held against the schema of the standard (OGC 07-147r2), which fastkml brings.
"""

import json
import sys

import fastkml
import geojson
import gpxpy
import shapely
from fastkml import Folder, Placemark
from fastkml.utils import find_all
from fastkml.validator import validate


# By itself the library rounds to 6 decimals.
geojson.geometry.DEFAULT_PRECISION = 15


def with_geojson(path):
    with open(path) as file:
        collection = geojson.load(file)
    assert collection.is_valid, collection.errors()
    seen = []
    for feature in collection["features"]:
        shape = shapely.geometry.shape(feature["geometry"])
        assert shape.is_valid, shapely.is_valid_reason(shape)
        polygons = [part for part in getattr(shape, "geoms", [shape]) if part.geom_type == "Polygon"]
        covers = feature["properties"]["kind"] in {"cleared", "not_searched"}
        assert not covers or all(part.exterior.is_ccw for part in polygons)
        seen.append(
            {
                "properties": feature["properties"],
                "type": shape.geom_type,
                "bounds": shape.bounds,
                "square_degrees": shape.area,
                "positions": [list(position) for position in shape.coords] if shape.geom_type == "LineString" else [],
            }
        )
    return {"features": seen, "pod": collection["pod"], "pos": collection["pos"]}


def with_fastkml(path):
    assert validate(file_to_validate=path)
    root = fastkml.KML.parse(path)
    seen = []
    for folder in find_all(root, of_type=Folder):
        for placemark in find_all(folder, of_type=Placemark):
            data = placemark.extended_data.elements if placemark.extended_data else []
            times = placemark.times
            seen.append(
                {
                    "folder": folder.name,
                    "name": placemark.name,
                    "data": {element.name: element.value for element in data},
                    "bounds": shapely.geometry.shape(placemark.geometry).bounds,
                    "square_degrees": shapely.geometry.shape(placemark.geometry).area,
                    "times": [str(getattr(times, key).dt) for key in ("timestamp", "begin", "end") if getattr(times, key, None)],
                }
            )
    return seen


def with_gpxpy(path):
    with open(path) as file:
        gpx = gpxpy.parse(file)
    point = lambda it: [it.longitude, it.latitude, it.time.isoformat()]
    return {
        "waypoints": [[it.name, it.description, *point(it)] for it in gpx.waypoints],
        "tracks": {track.name: [point(it) for it in track.segments[0].points] for track in gpx.tracks},
        "version": gpx.version,
    }


if __name__ == "__main__":
    geojson_path, kml_path, gpx_path = sys.argv[1:]
    print(
        json.dumps(
            {"geojson": with_geojson(geojson_path), "kml": with_fastkml(kml_path), "gpx": with_gpxpy(gpx_path)}
        )
    )
