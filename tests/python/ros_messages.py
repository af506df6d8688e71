"""Prints as JSON the bytes, in hexadecimal, of messages as rosbags encodes them.

Usage: ros_messages.py
"""

import json

import numpy as np
from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores.ROS2_JAZZY)


def make(name, **fields):
    return store.types[name](**fields)


def header(frame):
    stamp = make("builtin_interfaces/msg/Time", sec=7, nanosec=8)
    return make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def transform(parent, child, x):
    return make(
        "geometry_msgs/msg/TransformStamped",
        header=header(parent),
        child_frame_id=child,
        transform=make(
            "geometry_msgs/msg/Transform",
            translation=make("geometry_msgs/msg/Vector3", x=x, y=-2.0, z=0.5),
            rotation=make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.6, w=0.8),
        ),
    )


nan = float("nan")
messages = [
    make("tf2_msgs/msg/TFMessage", transforms=[transform("map", "odom", 1.5), transform("odom", "base_link", 3.0)]),
    make(
        "sensor_msgs/msg/CameraInfo",
        header=header("front_optical"),
        height=480,
        width=640,
        distortion_model="plumb_bob",
        d=np.array([0.1, -0.2, 0.001, 0.002, 0.03]),
        k=np.array([500.0, 0.0, 320.0, 0.0, 510.0, 240.0, 0.0, 0.0, 1.0]),
        r=np.eye(3).reshape(-1),
        p=np.array([490.0, 0.0, 321.0, 0.0, 0.0, 491.0, 241.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        binning_x=0,
        binning_y=2,
        roi=make("sensor_msgs/msg/RegionOfInterest", x_offset=1, y_offset=2, height=3, width=4, do_rectify=True),
    ),
    make("std_msgs/msg/Bool", data=True),
    make(
        "sensor_msgs/msg/BatteryState",
        header=header(""),
        voltage=12.5,
        temperature=nan,
        current=-1.5,
        charge=nan,
        capacity=nan,
        design_capacity=nan,
        percentage=0.75,
        power_supply_status=2,
        power_supply_health=1,
        power_supply_technology=3,
        present=True,
        cell_voltage=np.array([4.1, 4.2, 4.2], dtype=np.float32),
        cell_temperature=np.array([], dtype=np.float32),
        location="left",
        serial_number="7",
    ),
]
print(json.dumps({m.__msgtype__: bytes(store.serialize_cdr(m, m.__msgtype__)).hex() for m in messages}))
