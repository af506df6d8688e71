"""Records a drive as `ros2 bag record --storage mcap` would, with a writer that is not ours.

Usage: write_bag.py FOLDER [images | stamps | tf] < {"name": "its ros2msg schema", ...}

The bag is FOLDER, which must not exist; its recording is FOLDER/NAME.mcap. A vehicle drives through a test_site at 10 m/s, first
along its southern edge and then north. Three cameras look around it, each a third, and see the one object: their detector's
boxes are recorded or, with `images`, what they show, the object in red. For three seconds no odometry comes. `/fix` is no
fix. With `stamps`, those of camera 1 are 20 s old, and those of camera 2 stand still. With `tf`, `/tf` takes the
place of `/odom`, `/tf_static` says how the cameras are mounted, and each has its `camera_info`.
"""

import json
import math
import sys
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

OBJECT = (70.0, 70.0)
WAY = [(10.0, 10.0), (70.0, 10.0), (70.0, 50.0), (10.0, 50.0), (10.0, 70.0), (66.0, 70.0)]
METERS_PER_SECOND, HERTZ = 10.0, 20
# Every so many places the cameras look; with images less often, since a network then looks at each.
PLACES_PER_LOOK, PLACES_PER_IMAGE = 2, 8
SILENT_SECONDS = (4.0, 7.0)
START_NS = 1_700_000_000_000_000_000
COLUMNS, ROWS = 192, 128
YAWS = [0.0, math.radians(120.0), math.radians(-120.0)]
FOCAL_COLUMNS = COLUMNS / 2 / math.tan(math.radians(125.0) / 2)
# Columns and rows of what the object covers, whatever its distance.
WIDE, TALL = 8, 40


def drive():
    """Where the vehicle is, and which way it looks, at each time in seconds."""
    number = 0
    for (x, y), (to_x, to_y) in zip(WAY, WAY[1:]):
        heading, length = math.atan2(to_y - y, to_x - x), math.hypot(to_x - x, to_y - y)
        for step in range(round(length / METERS_PER_SECOND * HERTZ)):
            way = step / HERTZ * METERS_PER_SECOND
            yield number / HERTZ, x + way * math.cos(heading), y + way * math.sin(heading), heading
            number += 1


def column(x, y, heading, yaw):
    """Where a camera sees the object, columns from the left; nothing if it does not."""
    bearing = math.atan2(OBJECT[1] - y, OBJECT[0] - x) - heading - yaw
    bearing = math.atan2(math.sin(bearing), math.cos(bearing))
    if abs(bearing) >= math.pi / 2:
        return None
    column = COLUMNS / 2 - FOCAL_COLUMNS * math.tan(bearing)
    return column if WIDE / 2 < column < COLUMNS - WIDE / 2 else None


def yaw(radians):
    return 0.0, 0.0, math.sin(radians / 2), math.cos(radians / 2)


class Messages:
    def __init__(self, schemas):
        self.store = get_typestore(Stores.ROS2_JAZZY)
        known = set(self.store.fielddefs)
        for name, schema in schemas.items():
            types = get_types_from_msg(schema, name)
            self.store.register({other: fields for other, fields in types.items() if other not in known})

    def make(self, name, **fields):
        return self.store.types[name](**fields)

    def header(self, time_ns, frame):
        stamp = self.make("builtin_interfaces/msg/Time", sec=time_ns // 10**9, nanosec=time_ns % 10**9)
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)

    def odometry(self, time_ns, x, y, heading):
        point = self.make("geometry_msgs/msg/Point", x=x, y=y, z=0.0)
        turn = self.make(
            "geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=math.sin(heading / 2), w=math.cos(heading / 2)
        )
        pose = self.make("geometry_msgs/msg/Pose", position=point, orientation=turn)
        none = self.make("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=0.0)
        twist = self.make("geometry_msgs/msg/Twist", linear=none, angular=none)
        unknown = np.zeros(36)
        return self.make(
            "nav_msgs/msg/Odometry",
            header=self.header(time_ns, "map"),
            child_frame_id="base_link",
            pose=self.make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=unknown),
            twist=self.make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=unknown),
        )

    def transform(self, time_ns, parent, child, turn, x=0.0, y=0.0):
        i, j, k, w = turn
        return self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(time_ns, parent),
            child_frame_id=child,
            transform=self.make(
                "geometry_msgs/msg/Transform",
                translation=self.make("geometry_msgs/msg/Vector3", x=x, y=y, z=0.0),
                rotation=self.make("geometry_msgs/msg/Quaternion", x=i, y=j, z=k, w=w),
            ),
        )

    def transforms(self, *transforms):
        return self.make("tf2_msgs/msg/TFMessage", transforms=list(transforms))

    def place(self, time_ns, x, y, heading):
        """Odometry's frame is 5 m east of the map's."""
        return self.transforms(
            self.transform(time_ns, "map", "odom", yaw(0.0), x=5.0),
            self.transform(time_ns, "odom", "base_link", yaw(heading), x=x - 5.0, y=y),
        )

    def mounting(self, time_ns):
        """Each camera's link looks where the camera does; its optical frame has z forward."""
        links = [self.transform(time_ns, "base_link", f"link_{n}", yaw(turn)) for n, turn in enumerate(YAWS)]
        optical = [self.transform(time_ns, f"link_{n}", f"camera_{n}", (-0.5, 0.5, -0.5, 0.5)) for n in range(3)]
        return self.transforms(*links, *optical)

    def calibration(self, time_ns, frame):
        focal, columns, rows = FOCAL_COLUMNS, COLUMNS / 2 - 0.5, ROWS / 2 - 0.5
        return self.make(
            "sensor_msgs/msg/CameraInfo",
            header=self.header(time_ns, frame),
            height=ROWS,
            width=COLUMNS,
            distortion_model="plumb_bob",
            d=np.zeros(5),
            k=np.array([focal, 0.0, columns, 0.0, focal, rows, 0.0, 0.0, 1.0]),
            r=np.eye(3).reshape(-1),
            p=np.zeros(12),
            binning_x=0,
            binning_y=0,
            roi=self.make(
                "sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
            ),
        )

    def boxes(self, time_ns, column, frame="camera"):
        found = []
        if column is not None:
            point = self.make("vision_msgs/msg/Point2D", x=column, y=ROWS / 2)
            center = self.make("vision_msgs/msg/Pose2D", position=point, theta=0.0)
            bbox = self.make("vision_msgs/msg/BoundingBox2D", center=center, size_x=float(WIDE), size_y=float(TALL))
            header = self.header(time_ns, frame)
            found.append(self.make("vision_msgs/msg/Detection2D", header=header, results=[], bbox=bbox, id=""))
        header = self.header(time_ns, frame)
        return self.make("vision_msgs/msg/Detection2DArray", header=header, detections=found)

    def image(self, time_ns, column):
        pixels = np.full((ROWS, COLUMNS, 3), 114, dtype=np.uint8)
        if column is not None:
            left, top = round(column - WIDE / 2), (ROWS - TALL) // 2
            pixels[top : top + TALL, left : left + WIDE] = (230, 10, 10)
        return self.make(
            "sensor_msgs/msg/Image",
            header=self.header(time_ns, "camera"),
            height=ROWS,
            width=COLUMNS,
            encoding="rgb8",
            is_bigendian=0,
            step=3 * COLUMNS,
            data=pixels.reshape(-1),
        )


def main():
    folder, has_images, has_bad_stamps = Path(sys.argv[1]), "images" in sys.argv[2:], "stamps" in sys.argv[2:]
    has_tf = "tf" in sys.argv[2:]
    messages = Messages(json.load(sys.stdin))
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics = {}

        def say(topic, time_ns, message):
            name = message.__msgtype__
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, name, typestore=messages.store)
            writer.write(topics[topic], time_ns, messages.store.serialize_cdr(message, name))

        if has_tf:
            say("/tf_static", START_NS, messages.mounting(START_NS))
        places_per_look = PLACES_PER_IMAGE if has_images else PLACES_PER_LOOK
        for seconds, x, y, heading in drive():
            time_ns = START_NS + round(seconds * 1e9)
            if has_tf and not SILENT_SECONDS[0] <= seconds < SILENT_SECONDS[1]:
                say("/tf", time_ns, messages.place(time_ns, x, y, heading))
            elif not has_tf and not SILENT_SECONDS[0] <= seconds < SILENT_SECONDS[1]:
                say("/odom", time_ns, messages.odometry(time_ns, x, y, heading))
            for number, yaw in enumerate(YAWS) if round(seconds * HERTZ) % places_per_look == 0 else []:
                seen = column(x, y, heading, yaw)
                stamp_ns = [time_ns, time_ns - 20 * 10**9, START_NS + 10**9][number] if has_bad_stamps else time_ns
                if has_tf:
                    frame = f"camera_{number}"
                    say(f"/{frame}/camera_info", time_ns, messages.calibration(stamp_ns, frame))
                    say(f"/{frame}/detections", time_ns, messages.boxes(stamp_ns, seen, frame))
                elif has_images:
                    say(f"/camera_{number}/image", time_ns, messages.image(stamp_ns, seen))
                else:
                    say(f"/camera_{number}/detections", time_ns, messages.boxes(stamp_ns, seen))
            if seconds % 1 == 0:
                say("/fix", time_ns, messages.make("std_msgs/msg/String", data="none"))


main()
