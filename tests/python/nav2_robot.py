"""A robot that drives with Nav2, as its ROS 2 network shows it over rmw_zenoh: by eclipse-zenoh and rosbags.

Usage: nav2_robot.py ENDPOINT [late] [uncalibrated]

ENDPOINT is a Zenoh router's. The robot drives straight to each goal of /goal_pose. Localization says where odometry's frame
is, odometry where the robot is in it, both on /tf; robot_state_publisher and a camera's driver say on /tf_static how the
cameras are mounted, once. The cameras distort; their detectors find the one object. Published are, too, /e_stop, and
/battery_state.

Lines on standard input change it: `stop true`, `stop false`, `charge 0.15`, `mount` (publishes /tf_static, with `late` not done
at the start), `calibrate` (calibrations, with `uncalibrated` zeros until then), `loop` (a transform that makes a loop),
`lose odom` and `find odom` (odometry's transforms cease). Each of what it receives is a line of JSON on standard output; the first
says that it is ready.
"""

import json
import math
import sys
import threading
import time

import numpy as np

from ros_network import OPTICAL, Network, rotation

OBJECT = np.array([70.0, 70.0, 0.3])
METERS_PER_SECOND, HERTZ = 8.0, 20
COLUMNS, ROWS = 640, 480
RANGE_METERS = 60.0
# Odometry began elsewhere, turned, and drifts.
ODOM_IN_MAP = (3.0, -2.0, 0.4)


class Camera:
    """Its link on the vehicle, and its lens."""

    def __init__(self, name, place, angles, focal, center, model, d):
        self.name, self.place, self.angles = name, np.array(place), angles
        self.focal, self.center, self.model, self.d = focal, center, model, d
        self.turn = rotation(*angles) @ rotation(*OPTICAL)

    def pixel(self, point):
        """Where a point of the vehicle's frame is in the image; nothing if it is not."""
        x, y, z = self.turn.T @ (point - self.place)
        if z <= 0.05 or not 1.0 < math.hypot(x, z) < RANGE_METERS:
            return None
        if self.model == "equidistant":
            k1, k2, k3, k4 = self.d
            radius = math.hypot(x, y)
            a = math.atan2(radius, z)
            scale = a * (1 + k1 * a**2 + k2 * a**4 + k3 * a**6 + k4 * a**8) / max(radius, 1e-12)
            u, v = x * scale, y * scale
        else:
            k1, k2, p1, p2, k3 = self.d
            x, y = x / z, y / z
            r2 = x * x + y * y
            # Beyond the image the model has no meaning.
            if r2 > 4.0:
                return None
            factor = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
            u = x * factor + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
            v = y * factor + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        column = self.focal * u + self.center[0] + 0.5
        row = self.focal * v + self.center[1] + 0.5
        return (column, row) if 5 < column < COLUMNS - 5 and 5 < row < ROWS - 5 else None


CAMERAS = [
    Camera("front", (0.4, 0.0, 0.5), (0.0, 0.05, 0.3), 260.0, (322.0, 238.0), "plumb_bob", (-0.2, 0.03, 0.001, -0.001, 0.0)),
    Camera("rear", (-0.3, 0.1, 0.6), (0.02, 0.1, -2.8), 300.0, (315.0, 243.0), "equidistant", (0.01, -0.005, 0.0, 0.0)),
]


class Robot:
    def __init__(self, network, options):
        self.network, self.place, self.heading = network, np.array([10.0, 10.0]), 0.3
        self.goal, self.goals, self.number = None, [], 0
        self.is_calibrated = "uncalibrated" not in options
        self.has_odom, self.charge, self.stopped = True, 0.75, False
        if "late" not in options:
            self.mount()

    def mount(self):
        front, rear = CAMERAS
        for camera, node in ((front, "robot_state_publisher"), (rear, "driver")):
            name = camera.name
            link = self.network.transform("base_link", f"{name}_link", camera.place, camera.angles)
            optical = self.network.transform(f"{name}_link", f"{name}_optical", (0.0, 0.0, 0.0), OPTICAL)
            self.network.publish("tf_static", self.network.tf(link, optical), latched=node)

    def receive_goal(self, message):
        position = message.pose.position
        self.goal = np.array([position.x, position.y])
        self.number += 1
        self.goals = [(self.number, 2)]
        tell({"goal": [position.x, position.y]})

    def drive(self, seconds):
        if self.goal is None:
            return
        offset, step = self.goal - self.place, METERS_PER_SECOND * seconds
        distance = float(np.linalg.norm(offset))
        if distance > 0.01:
            self.heading = math.atan2(offset[1], offset[0])
        if distance <= step:
            self.place, self.goal, self.goals = self.goal, None, [(self.number, 4)]
        else:
            self.place = self.place + offset * (step / distance)

    def say(self, count):
        network = self.network
        odom_x, odom_y, odom_yaw = ODOM_IN_MAP
        if count % 2 == 0:
            # As AMCL dates it.
            network.publish("tf", network.tf(network.transform("map", "odom", (odom_x, odom_y, 0.0), (0, 0, odom_yaw), 0.5)))
        if self.has_odom:
            x, y = rotation(0, 0, -odom_yaw)[:2, :2] @ (self.place - np.array([odom_x, odom_y]))
            angles = (0.0, 0.0, self.heading - odom_yaw)
            network.publish("tf", network.tf(network.transform("odom", "base_link", (x, y, 0.0), angles)))
        for camera in CAMERAS:
            self.look(camera)
        network.publish("e_stop", network.make("std_msgs/msg/Bool", data=self.stopped))
        if count % HERTZ == 0:
            self.say_battery()
        network.publish("navigate_to_pose/_action/status", network.goal_statuses(self.goals))

    def look(self, camera):
        network = self.network
        header = network.header(f"{camera.name}_optical")
        focal, center = (camera.focal, camera.center) if self.is_calibrated else (0.0, (0.0, 0.0))
        info = network.camera_info(header, (COLUMNS, ROWS), focal, center, camera.model, camera.d)
        network.publish(f"{camera.name}/camera_info", info)
        point = rotation(0, 0, -self.heading) @ (OBJECT - np.array([*self.place, 0.0]))
        pixel = camera.pixel(point)
        network.publish(f"{camera.name}/detections", network.detections(header, [pixel] if pixel else []))

    def say_battery(self):
        nan, none = float("nan"), np.array([], dtype=np.float32)
        battery = self.network.make(
            "sensor_msgs/msg/BatteryState",
            header=self.network.header(""),
            voltage=24.5,
            temperature=nan,
            current=-2.0,
            charge=nan,
            capacity=nan,
            design_capacity=nan,
            percentage=self.charge,
            power_supply_status=2,
            power_supply_health=1,
            power_supply_technology=2,
            present=True,
            cell_voltage=none,
            cell_temperature=none,
            location="",
            serial_number="",
        )
        self.network.publish("battery_state", battery)

    def obey(self, line):
        match line.split():
            case ["stop", value]:
                self.stopped = value == "true"
            case ["charge", value]:
                self.charge = float(value)
            case ["mount"]:
                self.mount()
            case ["calibrate"]:
                self.is_calibrated = True
            case ["lose", "odom"]:
                self.has_odom = False
            case ["find", "odom"]:
                self.has_odom = True
            case ["loop"]:
                loop = self.network.transform("base_link", "map", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
                self.network.publish("tf", self.network.tf(loop))


OUTPUT = threading.Lock()


def tell(value):
    # Zenoh receives on several threads.
    with OUTPUT:
        print(json.dumps(value), flush=True)


def main():
    endpoint, *options = sys.argv[1:]
    network = Network(endpoint)
    robot, is_over = Robot(network, options), threading.Event()
    network.subscribe("goal_pose", "geometry_msgs/msg/PoseStamped", robot.receive_goal)

    def receive_objects(message):
        places = [[d.results[0].pose.pose.position, d.results[0].pose.covariance, d.bbox.center.position] for d in message.detections]
        tell({"objects": [[p.x, p.y, c[0], c[7], m.x, m.y] for p, c, m in places]})

    def receive_diagnostics(message):
        tell({"diagnostics": {s.name.removeprefix("dragnet: "): [int(s.level), s.message] for s in message.status}})

    network.subscribe("dragnet/objects", "vision_msgs/msg/Detection3DArray", receive_objects)
    network.subscribe("diagnostics", "diagnostic_msgs/msg/DiagnosticArray", receive_diagnostics)

    def obey():
        for line in sys.stdin:
            robot.obey(line)
        is_over.set()

    threading.Thread(target=obey, daemon=True).start()
    tell({"ready": True})
    count, next_at = 0, time.monotonic()
    while not is_over.is_set():
        robot.drive(1 / HERTZ)
        robot.say(count)
        count += 1
        next_at += 1 / HERTZ
        time.sleep(max(0.0, next_at - time.monotonic()))
    network.session.close()


main()
