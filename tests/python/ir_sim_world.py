"""A world that Dragnet's authors did not write: the robots, walls and collisions of ir-sim, and each robot's ROS 2 network.

Usage: ir_sim_world.py WORLD.toml [--seconds SECONDS] [--seed SEED] [--picture FILE]

WORLD.toml names a scenario whose map a `nav2_map_server` saved, where the objects are, and for each robot where its network
listens and where it starts; all places are in meters in the map's frame:

    scenario = "yard.toml"
    objects = [[12.5, 2.5], [-13.5, 8.6]]
    [[robots]]
    listen = "tcp/127.0.0.1:7447"
    start = [-13.0, -9.0, 0.0]

Robots have two driven wheels. Each has a router in the place of `rmw_zenohd`, and publishes the map, odometry that drifts,
what localization makes of it (/amcl_pose, and /tf), two cameras (/tf_static, camera_info) and what their detectors find. It
follows each path of /dragnet/path, and drives to each goal of /goal_pose on a shortest path that keeps away from walls, as
`bt_navigator` does. Detectors miss objects, see some that are not there, and see none through walls or robots.

The world ends after SECONDS, or when it is told to (SIGTERM, Ctrl-C). Lines of JSON on standard output say that it is ready
and in which cells [row, column] the objects are, and tell collisions and the end; a collision makes the exit status 1.
`--picture` draws where the robots drove.
"""

import argparse
import json
import math
import pathlib
import signal
import sys
import tempfile
import threading
import time
import tomllib

import numpy as np
import shapely
import yaml
from scipy import ndimage, sparse
from scipy.sparse.csgraph import dijkstra

from ros_network import OPTICAL, Network, rotation

# Standard output is for JSON; ir-sim prints when it is imported.
OUTPUT, sys.stdout = sys.stdout, sys.stderr
import irsim
from matplotlib.figure import Figure
from matplotlib.image import imread

HERTZ = 20
RADIUS_METERS = 0.25
METERS_PER_SECOND, RADIANS_PER_SECOND = 2.0, 3.0
# Pure pursuit steers to a point this far ahead; one that is farther to the side than this is turned to on the spot.
LOOKAHEAD_METERS, ON_THE_SPOT_RADIANS = 0.4, 0.8
CLOSE_METERS = 0.05
# Of two robots that meet the second one stands while the first one moves, which slows down and passes it, on the right if there is
# room; and none drives on to another one right ahead.
MEETING_METERS, MEETING_RADIANS, ASIDE_METERS, LOOKAHEAD_MEETING_METERS = 6.0, 1.0, 0.7, 1.0
ROOM_METERS, SLOW_METERS, SLOW_METERS_PER_SECOND = 0.3, 3.0, 1.0
YIELD_METERS, YIELD_RADIANS = 2.5, 1.7
STOP_METERS, STOP_RADIANS = 0.9, 0.6
# The robot's own planner keeps this far from occupied squares, and a path may end this far from its goal.
CLEARANCE_METERS, TOLERANCE_METERS = 0.6, 0.5

# Localization: noise, for how long it lasts, and what the vehicle has driven or turned before it publishes again, as in AMCL.
POSE_STD_METERS, POSE_STD_RADIANS, POSE_CORRELATION_SECONDS = 0.03, 0.008, 1.0
POSE_EVERY_METERS, POSE_EVERY_RADIANS = 0.1, 0.1
# Odometry: scale of distances and of turns.
ODOMETRY_SCALE, ODOMETRY_TURN_SCALE = 1.02, 0.98

COLUMNS, ROWS, FOCAL_PIXELS = 640, 480, 260.0
# Place and direction on the vehicle.
CAMERAS = {"front": ((0.2, 0.0, 0.5), (0.0, 0.0, 0.0)), "rear": ((-0.2, 0.0, 0.5), (0.0, 0.0, math.pi))}
OBJECT_HEIGHT_METERS = 0.3
RANGE_METERS = (0.3, 8.0)
MISS_PROBABILITY, FALSE_ALARM_PROBABILITY, BOX_STD_PIXELS = 0.15, 0.01, 2.0

EXECUTING, SUCCEEDED, ABORTED = 2, 4, 6


def wrapped(radians):
    return math.remainder(radians, 2 * math.pi)


def composed(parent, child):
    """Poses x, y, heading: that of a child in the frame of its parent's parent."""
    x, y, heading = parent
    forward, left, turn = child
    c, s = math.cos(heading), math.sin(heading)
    return np.array([x + c * forward - s * left, y + s * forward + c * left, wrapped(heading + turn)])


def inverse(pose):
    x, y, heading = pose
    c, s = math.cos(heading), math.sin(heading)
    return np.array([-c * x - s * y, s * x - c * y, -heading])


class RosMap:
    """A map as `nav2_map_server` saved it, without rotation."""

    def __init__(self, file):
        settings = yaml.safe_load(file.read_text())
        self.image = file.parent / settings["image"]
        self.resolution = settings["resolution"]
        self.origin = settings["origin"][:2]
        dark = 1.0 - imread(self.image) / 255.0
        self.occupancy = np.full(dark.shape, -1, dtype=np.int8)
        self.occupancy[dark < settings["free_thresh"]] = 0
        self.occupancy[dark > settings["occupied_thresh"]] = 100
        # The first row is the southern one, as in an OccupancyGrid.
        self.occupancy = self.occupancy[::-1]

    @property
    def size_meters(self):
        rows, columns = self.occupancy.shape
        return columns * self.resolution, rows * self.resolution


class Planner:
    """The planner of a robot's own navigation: shortest paths on a map's squares that are far enough from walls."""

    def __init__(self, ros_map):
        self.origin, self.resolution = np.array(ros_map.origin), ros_map.resolution
        self.room_meters = ndimage.distance_transform_edt(ros_map.occupancy == 0) * self.resolution
        is_open = self.room_meters >= CLEARANCE_METERS
        rows, columns = np.nonzero(is_open)
        self.middles = self.origin + (np.stack([columns, rows], axis=1) + 0.5) * self.resolution
        numbers = np.full(is_open.shape, -1)
        numbers[rows, columns] = np.arange(len(rows))
        padded, edges = np.pad(numbers, 1, constant_values=-1), []
        for north, east in ((0, 1), (1, 0), (1, 1), (1, -1)):
            neighbors = padded[1 + north :, 1 + east :][: is_open.shape[0], : is_open.shape[1]]
            both = (numbers >= 0) & (neighbors >= 0)
            edges.append((numbers[both], neighbors[both], np.full(both.sum(), math.hypot(north, east))))
        begins, ends, lengths = (np.concatenate(parts) for parts in zip(*edges, strict=True))
        self.graph = sparse.csr_matrix((lengths, (begins, ends)), shape=(len(rows), len(rows)))

    def has_room(self, place):
        """Whether a robot fits there, on the map."""
        column, row = np.floor((place - self.origin) / self.resolution).astype(int)
        return self.room_meters[row, column] >= ROOM_METERS

    def nearest(self, place):
        distances = np.linalg.norm(self.middles - place, axis=1)
        number = int(np.argmin(distances))
        return number, distances[number]

    def path(self, start, goal):
        """Points from a start to a goal, or to the nearest place within the tolerance; nothing if no path leads there."""
        (begin, _), (end, off_meters) = self.nearest(start), self.nearest(goal)
        if off_meters > TOLERANCE_METERS:
            return None
        lengths, before = dijkstra(self.graph, directed=False, indices=end, return_predecessors=True)
        if not math.isfinite(lengths[begin]):
            return None
        numbers = [begin]
        while numbers[-1] != end:
            numbers.append(before[numbers[-1]])
        return [self.middles[number] for number in numbers]


class Robot:
    def __init__(self, number, body, network, world):
        self.number, self.body, self.network, self.world = number, body, network, world
        self.random = np.random.default_rng([world.seed, number])
        self.lock = threading.Lock()
        self.points, self.passed = [], 0
        self.is_moving = False
        self.goal_number, self.goals = 0, []
        self.odometry, self.last = np.zeros(3), self.pose
        self.pose_error, self.estimate, self.estimated_at = np.zeros(3), None, None
        self.meters = 0.0
        grid = network.occupancy_grid(world.map.occupancy, world.map.resolution, world.map.origin)
        network.publish("map", grid, latched="map_server")
        for name, (place, angles) in CAMERAS.items():
            link = network.transform("base_link", f"{name}_link", place, angles)
            optical = network.transform(f"{name}_link", f"{name}_optical", (0.0, 0.0, 0.0), OPTICAL)
            network.publish("tf_static", network.tf(link, optical), latched=name)
        network.subscribe("dragnet/path", "nav_msgs/msg/Path", self.receive_path)
        network.subscribe("goal_pose", "geometry_msgs/msg/PoseStamped", self.receive_goal)

    @property
    def pose(self):
        return self.body.state[:3, 0].copy()

    def receive_path(self, message):
        places = [pose.pose.position for pose in message.poses]
        with self.lock:
            self.points, self.passed = [np.array([place.x, place.y]) for place in places], 0

    def receive_goal(self, message):
        position = message.pose.position
        path = self.world.planner.path(self.pose[:2], np.array([position.x, position.y]))
        with self.lock:
            self.goal_number += 1
            self.goals = [(self.goal_number, EXECUTING if path else ABORTED)]
            self.points, self.passed = path or [], 0
        if path is None:
            tell({"aborted": {"robot": self.number, "goal": [position.x, position.y]}})

    def command(self):
        """Speed and rate of turn, by pure pursuit."""
        with self.lock:
            here, heading = self.pose[:2], self.pose[2]
            is_meeting = self.nears(MEETING_METERS, MEETING_RADIANS)
            target = self.target(here, LOOKAHEAD_MEETING_METERS if is_meeting else LOOKAHEAD_METERS)
            if target is None:
                if self.goals and self.goals[0][1] == EXECUTING:
                    self.goals = [(self.goal_number, SUCCEEDED)]
                return 0.0, 0.0
            if self.nears(YIELD_METERS, YIELD_RADIANS, lambda other: other.number < self.number and other.is_moving):
                return 0.0, 0.0
            offset = (self.aside(here, target) if is_meeting else target) - here
            distance = float(np.linalg.norm(offset))
            turn = wrapped(math.atan2(offset[1], offset[0]) - heading)
            if abs(turn) > ON_THE_SPOT_RADIANS:
                return 0.0, float(np.clip(3.0 * turn, -RADIANS_PER_SECOND, RADIANS_PER_SECOND))
            if self.nears(STOP_METERS, STOP_RADIANS):
                return 0.0, 0.0
            end_meters = float(np.linalg.norm(self.points[-1] - here))
            # The speed from which it can stop, and at which it can take the curve.
            curvature = 2.0 * math.sin(turn) / max(distance, 0.1)
            most = SLOW_METERS_PER_SECOND if self.nears(SLOW_METERS, MEETING_RADIANS) else METERS_PER_SECOND
            speed = min(most, math.sqrt(2.0 * end_meters), RADIANS_PER_SECOND / 2.0 / max(abs(curvature), 1e-6))
            return speed, speed * curvature

    def target(self, here, lookahead_meters):
        """The next point of the path that is far enough ahead, or its end; nothing there."""
        while self.passed + 1 < len(self.points) and (
            np.linalg.norm(self.points[self.passed + 1] - here) <= np.linalg.norm(self.points[self.passed] - here)
        ):
            self.passed += 1
        rest = self.points[self.passed :]
        if not rest or (len(rest) == 1 and np.linalg.norm(rest[0] - here) <= CLOSE_METERS):
            self.points, self.passed = [], 0
            return None
        return next((point for point in rest if np.linalg.norm(point - here) >= lookahead_meters), rest[-1])

    def aside(self, here, target):
        """A point beside the next one of the path, where there is room for a robot."""
        ahead = target - here
        right = np.array([ahead[1], -ahead[0]]) / max(float(np.linalg.norm(ahead)), 0.1) * ASIDE_METERS
        return next(filter(self.world.planner.has_room, (target + right, target - right)), target)

    def nears(self, meters, radians, is_meant=lambda other: True):
        """Whether such a robot is so near, and no farther to either side."""
        x, y, heading = self.pose
        for other in self.world.robots:
            offset = other.pose[:2] - (x, y)
            turn = wrapped(math.atan2(offset[1], offset[0]) - heading)
            if other is not self and abs(turn) < radians and np.linalg.norm(offset) < meters and is_meant(other):
                return True
        return False

    def say(self, count):
        network, pose = self.network, self.pose
        forward, left, turn = composed(inverse(self.last), pose)
        self.meters += math.hypot(forward, left)
        step = np.array([forward * ODOMETRY_SCALE, left * ODOMETRY_SCALE, turn * ODOMETRY_TURN_SCALE])
        self.odometry, self.last = composed(self.odometry, step), pose
        x, y, heading = self.odometry
        network.publish("odom", network.odometry(self.odometry, forward * HERTZ, turn * HERTZ))
        network.publish("tf", network.tf(network.transform("odom", "base_link", (x, y, 0.0), (0.0, 0.0, heading))))
        self.localize(pose)
        if count % 2 == 0:
            for name in CAMERAS:
                self.look(name, pose)
        network.publish("navigate_to_pose/_action/status", network.goal_statuses(self.goals))

    def localize(self, pose):
        kept = math.exp(-1.0 / HERTZ / POSE_CORRELATION_SECONDS)
        std = np.array([POSE_STD_METERS, POSE_STD_METERS, POSE_STD_RADIANS])
        self.pose_error = kept * self.pose_error + math.sqrt(1 - kept**2) * std * self.random.standard_normal(3)
        if self.estimate is None or self.has_moved(pose):
            self.estimate, self.estimated_at = pose + self.pose_error, pose
            self.correction = composed(self.estimate, inverse(self.odometry))
            variances = (POSE_STD_METERS**2, POSE_STD_RADIANS**2)
            self.network.publish("amcl_pose", self.network.located("map", self.estimate, variances), latched="amcl")
        x, y, heading = self.correction
        # As AMCL dates it, ahead.
        self.network.publish(
            "tf", self.network.tf(self.network.transform("map", "odom", (x, y, 0.0), (0.0, 0.0, heading), 0.5))
        )

    def has_moved(self, pose):
        forward, left, turn = composed(inverse(self.estimated_at), pose)
        return math.hypot(forward, left) > POSE_EVERY_METERS or abs(turn) > POSE_EVERY_RADIANS

    def look(self, name, pose):
        network = self.network
        header = network.header(f"{name}_optical")
        center = (COLUMNS / 2 - 0.5, ROWS / 2 - 0.5)
        info = network.camera_info(header, (COLUMNS, ROWS), FOCAL_PIXELS, center, "plumb_bob", [0.0] * 5)
        network.publish(f"{name}/camera_info", info)
        pixels = [self.pixel(name, pose, place) for place in self.world.objects]
        seen = [pixel for pixel in pixels if pixel and self.random.random() >= MISS_PROBABILITY]
        if self.random.random() < FALSE_ALARM_PROBABILITY:
            seen.append((self.random.uniform(5, COLUMNS - 5), self.random.uniform(ROWS / 2, ROWS - 5)))
        network.publish(f"{name}/detections", network.detections(header, seen))

    def pixel(self, name, pose, place):
        """Where the detector sees an object in the image; nothing if it does not."""
        mounting, angles = CAMERAS[name]
        x, y, heading = pose
        turn = rotation(0.0, 0.0, heading)
        eye = np.array([x, y, 0.0]) + turn @ np.array(mounting)
        offset = np.array([*place, OBJECT_HEIGHT_METERS]) - eye
        right, down, ahead = (turn @ rotation(*angles) @ rotation(*OPTICAL)).T @ offset
        nearest, farthest = RANGE_METERS
        if ahead <= 0.05 or not nearest < math.hypot(right, ahead) < farthest:
            return None
        noise = BOX_STD_PIXELS * self.random.standard_normal(2)
        column = FOCAL_PIXELS * right / ahead + COLUMNS / 2 + noise[0]
        row = FOCAL_PIXELS * down / ahead + ROWS / 2 + noise[1]
        if not (5 < column < COLUMNS - 5 and 5 < row < ROWS - 5):
            return None
        return (column, row) if self.world.is_in_sight(eye[:2], place, self.body) else None


class World:
    def __init__(self, file, seed):
        settings = tomllib.loads(file.read_text())
        scenario_file = file.parent / settings["scenario"]
        scenario = tomllib.loads(scenario_file.read_text())
        self.seed = seed
        self.objects = [np.array(place) for place in settings["objects"]]
        self.map = RosMap(scenario_file.parent / scenario["map"]["file"])
        self.cell_meters = scenario["map"].get("cell_meters", 30.0)
        self.planner = Planner(self.map)
        self.simulation = self.simulate([robot["start"] for robot in settings["robots"]])
        (self.walls,) = [one for one in self.simulation.obstacle_list if one.shape == "map"]
        shapely.prepare(self.walls.geometry)
        self.collisions, self.robots = [], []
        for number, (robot, body) in enumerate(zip(settings["robots"], self.simulation.robot_list, strict=True), 1):
            self.robots.append(Robot(number, body, Network(robot["listen"], "router"), self))

    def simulate(self, starts):
        width, height = self.map.size_meters
        body = {
            "kinematics": {"name": "diff"},
            "shape": {"name": "circle", "radius": RADIUS_METERS},
            "vel_max": [METERS_PER_SECOND, RADIANS_PER_SECOND],
            "vel_min": [-METERS_PER_SECOND, -RADIANS_PER_SECOND],
            "acce": [2.0, 12.0],
        }
        world = {
            "width": width,
            "height": height,
            "offset": self.map.origin,
            "step_time": 1 / HERTZ,
            "obstacle_map": str(self.map.image.resolve()),
            # A robot that collides stays where it is.
            "collision_mode": "stop",
        }
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            yaml.safe_dump({"world": world, "robot": [{**body, "state": start} for start in starts]}, file)
            file.flush()
            return irsim.make(file.name, headless=True, log_level="CRITICAL")

    def is_in_sight(self, eye, place, own):
        sight = shapely.LineString([eye, place])
        others = [robot.body.geometry for robot in self.robots if robot.body is not own]
        return not any(shapely.intersects(shape, sight) for shape in (self.walls.geometry, *others))

    def cells(self):
        """The rows and columns of the objects' cells, from the south-western corner."""
        return [np.floor((place - self.map.origin) / self.cell_meters).astype(int)[::-1].tolist() for place in self.objects]

    def step(self, count, now):
        """One step, after which it is `now`: on a busy machine steps come late, and their stamps do not."""
        for robot in self.robots:
            robot.network.now = now
        commands = [np.array(robot.command()).reshape(2, 1) for robot in self.robots]
        for robot, command in zip(self.robots, commands, strict=True):
            robot.is_moving = bool(command.any())
        self.simulation.step(commands, action_id=[robot.body.id for robot in self.robots])
        for robot in self.robots:
            if robot.body.collision and robot.number not in [one["robot"] for one in self.collisions]:
                others = ["a wall" if other.shape == "map" else "a robot" for other in robot.body.collision_obj]
                self.collisions.append({"robot": robot.number, "with": others, "at": robot.pose.round(2).tolist()})
                tell({"collision": self.collisions[-1]})
            robot.say(count)

    def draw(self, file):
        width, height = self.map.size_meters
        axes = Figure(figsize=(width / 4, height / 4), layout="constrained").add_subplot()
        west, south = self.map.origin
        extent = (west, west + width, south, south + height)
        axes.imshow(-self.map.occupancy.astype(int), cmap="gray", origin="lower", extent=extent)
        for robot in self.robots:
            way = np.array(robot.body.trajectory)[:, :2, 0]
            axes.plot(way[:, 0], way[:, 1], label=f"robot {robot.number}: {robot.meters:.0f} m")
        places = np.array(self.objects).T
        axes.plot(*places, "r*", markersize=12, label="objects")
        axes.legend(loc="lower right")
        axes.figure.savefig(file)


OUTPUT_LOCK = threading.Lock()


def tell(value):
    # Zenoh receives on several threads.
    with OUTPUT_LOCK:
        print(json.dumps(value), file=OUTPUT, flush=True)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("world", type=pathlib.Path)
    arguments.add_argument("--seconds", type=float, default=math.inf)
    arguments.add_argument("--seed", type=int, default=0)
    arguments.add_argument("--picture", type=pathlib.Path)
    arguments = arguments.parse_args()
    is_over = threading.Event()
    for name in (signal.SIGTERM, signal.SIGINT):
        signal.signal(name, lambda *_: is_over.set())
    world = World(arguments.world, arguments.seed)
    tell({"ready": True, "cells": world.cells()})
    begin = next_at = time.monotonic()
    begin_ns = time.time_ns()
    count, slow = 0, 0.0
    while not is_over.is_set() and next_at - begin < arguments.seconds:
        world.step(count, begin_ns + count * 10**9 // HERTZ)
        count += 1
        next_at += 1 / HERTZ
        slow = max(slow, time.monotonic() - next_at)
        time.sleep(max(0.0, next_at - time.monotonic()))
    if arguments.picture:
        world.draw(arguments.picture)
    robots = [{"meters": round(robot.meters, 1), "at": robot.pose.round(2).tolist()} for robot in world.robots]
    seconds = round(next_at - begin, 1)
    tell({"ended": {"seconds": seconds, "late_seconds": round(slow, 2), "robots": robots, "collisions": world.collisions}})
    for robot in world.robots:
        robot.network.session.close()
    sys.exit(1 if world.collisions else 0)


if __name__ == "__main__":
    main()
