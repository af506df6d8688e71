"""The ROS 2 network of a robot over rmw_zenoh, without ROS: messages and type hashes by rosbags, transport by eclipse-zenoh."""

import json
import math
import time

import numpy as np
import zenoh
import zenoh.ext
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

VISION = {
    "vision_msgs/msg/Point2D": "float64 x\nfloat64 y\n",
    "vision_msgs/msg/Pose2D": "vision_msgs/Point2D position\nfloat64 theta\n",
    "vision_msgs/msg/BoundingBox2D": "vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y\n",
    "vision_msgs/msg/BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size\n",
    "vision_msgs/msg/ObjectHypothesis": "string class_id\nfloat64 score\n",
    "vision_msgs/msg/ObjectHypothesisWithPose": "vision_msgs/ObjectHypothesis hypothesis\n"
    "geometry_msgs/PoseWithCovariance pose\n",
    "vision_msgs/msg/Detection2D": "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
    "vision_msgs/BoundingBox2D bbox\nstring id\n",
    "vision_msgs/msg/Detection2DArray": "std_msgs/Header header\nvision_msgs/Detection2D[] detections\n",
    "vision_msgs/msg/Detection3D": "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
    "vision_msgs/BoundingBox3D bbox\nstring id\n",
    "vision_msgs/msg/Detection3DArray": "std_msgs/Header header\nvision_msgs/Detection3D[] detections\n",
}


def rotation(roll, pitch, yaw):
    (sr, cr), (sp, cp), (sy, cy) = [(math.sin(a), math.cos(a)) for a in (roll, pitch, yaw)]
    x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return z @ y @ x


def quaternion(roll, pitch, yaw):
    """x, y, z, w, by half angles."""
    (sr, cr), (sp, cp), (sy, cy) = [(math.sin(a / 2), math.cos(a / 2)) for a in (roll, pitch, yaw)]
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


# From a link on the vehicle to a camera's optical frame: roll, pitch, yaw.
OPTICAL = (-math.pi / 2, 0.0, -math.pi / 2)


class Network:
    """`client` of a router at an endpoint, or itself a `router` that listens there, in the place of `rmw_zenohd`."""

    def __init__(self, endpoint, mode="client"):
        self.store = get_typestore(Stores.ROS2_JAZZY)
        types = {}
        for name, text in VISION.items():
            types.update(get_types_from_msg(text, name))
        self.store.register(types)
        config = zenoh.Config()
        config.insert_json5("mode", json.dumps(mode))
        config.insert_json5("listen/endpoints" if mode == "router" else "connect/endpoints", json.dumps([endpoint]))
        config.insert_json5("scouting/multicast/enabled", "false")
        config.insert_json5("timestamping/enabled", "true")
        self.session = zenoh.open(config)
        self.publishers, self.sent = {}, 0
        # The time of what is said, in nanoseconds; without one, that at which it is.
        self.now = None

    def make(self, name, **fields):
        return self.store.types[name](**fields)

    def key(self, topic, name):
        package, _, short = name.split("/")
        return f"0/{topic}/{package}::msg::dds_::{short}_/{self.store.hash_rihs01(name)}"

    def publish(self, topic, message, latched=None):
        """Latched messages are kept for late subscribers, by one publisher for each `latched`."""
        if (topic, latched) not in self.publishers:
            key = self.key(topic, message.__msgtype__)
            if latched:
                publisher = zenoh.ext.declare_advanced_publisher(
                    self.session,
                    key,
                    cache=zenoh.ext.CacheConfig(1),
                    sample_miss_detection=zenoh.ext.MissDetectionConfig(sporadic_heartbeat=0.5),
                    publisher_detection=True,
                )
            else:
                publisher = self.session.declare_publisher(key)
            self.publishers[topic, latched] = publisher
        self.sent += 1
        attachment = self.sent.to_bytes(8, "little") + time.time_ns().to_bytes(8, "little") + b"\x10" + bytes(16)
        data = bytes(self.store.serialize_cdr(message, message.__msgtype__))
        self.publishers[topic, latched].put(data, attachment=attachment)

    def subscribe(self, topic, name, receive):
        def decode(sample):
            receive(self.store.deserialize_cdr(sample.payload.to_bytes(), name))

        self.session.declare_subscriber(self.key(topic, name), decode)

    def header(self, frame, ahead=0.0):
        now = (self.now or time.time_ns()) + int(ahead * 1e9)
        stamp = self.make("builtin_interfaces/msg/Time", sec=now // 10**9, nanosec=now % 10**9)
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)

    def transform(self, parent, child, place, angles, ahead=0.0):
        x, y, z = place
        i, j, k, w = quaternion(*angles)
        return self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(parent, ahead),
            child_frame_id=child,
            transform=self.make(
                "geometry_msgs/msg/Transform",
                translation=self.make("geometry_msgs/msg/Vector3", x=x, y=y, z=z),
                rotation=self.make("geometry_msgs/msg/Quaternion", x=i, y=j, z=k, w=w),
            ),
        )

    def tf(self, *transforms):
        return self.make("tf2_msgs/msg/TFMessage", transforms=list(transforms))

    def pose(self, x, y, heading):
        zw = {"z": math.sin(heading / 2), "w": math.cos(heading / 2)}
        return self.make(
            "geometry_msgs/msg/Pose",
            position=self.make("geometry_msgs/msg/Point", x=x, y=y, z=0.0),
            orientation=self.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, **zw),
        )

    def uncertain(self, pose, variances):
        """A pose x, y, heading with the variances of a coordinate and of the heading."""
        covariance = np.zeros((6, 6))
        covariance[0, 0] = covariance[1, 1] = variances[0]
        covariance[5, 5] = variances[1]
        return self.make("geometry_msgs/msg/PoseWithCovariance", pose=self.pose(*pose), covariance=covariance.reshape(-1))

    def located(self, frame, pose, variances):
        """The same with a frame, as localization publishes it."""
        located = self.uncertain(pose, variances)
        return self.make("geometry_msgs/msg/PoseWithCovarianceStamped", header=self.header(frame), pose=located)

    def odometry(self, pose, speed, rate):
        """The pose of `base_link` in `odom`, and its speeds."""
        make = self.make
        twist = make(
            "geometry_msgs/msg/Twist",
            linear=make("geometry_msgs/msg/Vector3", x=speed, y=0.0, z=0.0),
            angular=make("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=rate),
        )
        return make(
            "nav_msgs/msg/Odometry",
            header=self.header("odom"),
            child_frame_id="base_link",
            pose=self.uncertain(pose, (0.0, 0.0)),
            twist=make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=np.zeros(36)),
        )

    def occupancy_grid(self, occupancy, resolution, origin):
        """A map in percent, the first row the southern one, -1 where it is unknown."""
        rows, columns = occupancy.shape
        info = self.make(
            "nav_msgs/msg/MapMetaData",
            map_load_time=self.make("builtin_interfaces/msg/Time", sec=0, nanosec=0),
            resolution=resolution,
            width=columns,
            height=rows,
            origin=self.pose(*origin, 0.0),
        )
        return self.make("nav_msgs/msg/OccupancyGrid", header=self.header("map"), info=info, data=occupancy.reshape(-1))

    def camera_info(self, header, size, focal, center, model, d):
        """Calibration of a camera: columns and rows, focal length and principal point in pixels, and distortion."""
        columns, rows = size
        return self.make(
            "sensor_msgs/msg/CameraInfo",
            header=header,
            height=rows,
            width=columns,
            distortion_model=model,
            d=np.array(d),
            # Zeros say that it is not calibrated.
            k=np.array([focal, 0.0, center[0], 0.0, focal, center[1], 0.0, 0.0, 1.0 if focal else 0.0]),
            r=np.eye(3).reshape(-1),
            p=np.zeros(12),
            binning_x=0,
            binning_y=0,
            roi=self.make("sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False),
        )

    def detections(self, header, middles):
        """Boxes around these columns and rows."""
        make, found = self.make, []
        for column, row in middles:
            position = make("vision_msgs/msg/Point2D", x=column, y=row)
            center = make("vision_msgs/msg/Pose2D", position=position, theta=0.0)
            bbox = make("vision_msgs/msg/BoundingBox2D", center=center, size_x=8.0, size_y=8.0)
            found.append(make("vision_msgs/msg/Detection2D", header=header, results=[], bbox=bbox, id=""))
        return make("vision_msgs/msg/Detection2DArray", header=header, detections=found)

    def goal_statuses(self, goals):
        """The statuses of an action's goals, each a number and a state of `action_msgs/GoalStatus`."""
        make = self.make
        statuses = []
        for number, state in goals:
            uuid = make("unique_identifier_msgs/msg/UUID", uuid=np.array([number % 256] * 16, dtype=np.uint8))
            stamp = make("builtin_interfaces/msg/Time", sec=0, nanosec=0)
            info = make("action_msgs/msg/GoalInfo", goal_id=uuid, stamp=stamp)
            statuses.append(make("action_msgs/msg/GoalStatus", goal_info=info, status=state))
        return make("action_msgs/msg/GoalStatusArray", status_list=statuses)
