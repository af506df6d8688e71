"""Reads a recording with two ROS 2 readers that are not ours, and prints as JSON what each of them saw.

Usage: read_recording.py RECORDING

Both know our own messages only from the schemas in the file.
"""

import json
import sys
from io import BytesIO
from pathlib import Path

import zstandard
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader


def seconds(stamp):
    return stamp.sec + stamp.nanosec / 1e9


def posed(pose):
    return [pose.position.x, pose.position.y, pose.orientation.z, pose.orientation.w]


class CameraDetections:
    """What one reader saw."""

    def __init__(self):
        self.counts = {}
        self.observation_sums = {}
        self.poses = {}
        self.paths = {}
        self.frames = {}
        self.turns = []
        self.belief_origin = None
        self.map = None
        self.belief = None
        self.probability = None
        self.objects = []
        self.status = None
        self.digest = None
        self.log_times = []

    def take(self, topic, log_time, message):
        self.counts[topic] = self.counts.get(topic, 0) + 1
        self.log_times.append(log_time)
        subject = topic.rsplit("/", 1)[-1]
        if topic == "/map":
            self.map = {
                "data": [int(value) for value in message.data],
                "width": message.info.width,
                "height": message.info.height,
                "resolution": message.info.resolution,
                "origin": posed(message.info.origin),
            }
        elif topic == "/belief":
            self.belief = [int(value) for value in message.data]
            self.belief_origin = posed(message.info.origin)
        elif topic == "/belief/probability":
            self.probability = {
                "bytes": list(bytes(message.data)),
                "columns": message.column_count,
                "origin": posed(message.pose),
                "field": message.fields[0].name,
            }
        elif topic == "/tf":
            for transform in message.transforms:
                place = transform.transform.translation
                turn = transform.transform.rotation
                self.turns.append([turn.z, turn.w])
                self.frames.setdefault(transform.child_frame_id, []).append([place.x, place.y])
        elif topic == "/objects":
            self.objects.append([message.cell, message.probability, message.time_ns])
        elif topic == "/mission/status":
            self.status = {
                "declared": [object.cell for object in message.declared],
                "alive": [int(robot) for robot in message.alive],
                "observations": message.observations,
                "expected_remaining": message.expected_remaining,
            }
            self.digest = [str(half) for half in message.digest]
        elif subject == "observation":
            total = self.observation_sums.get(topic, 0.0)
            self.observation_sums[topic] = total + sum(float(value) for value in message.values)
        elif subject == "pose":
            place = message.pose.position
            self.poses.setdefault(topic, []).append([place.x, place.y, seconds(message.header.stamp)])
        elif subject == "path":
            places = [[pose.pose.position.x, pose.pose.position.y] for pose in message.poses]
            self.paths.setdefault(topic, []).append(places)


def read_attachment(found):
    """Text, or the topics of a recording within the recording."""
    if not found.name.endswith(".mcap.zst"):
        return found.data.decode()
    recording = zstandard.ZstdDecompressor().decompressobj().decompress(found.data)
    messages = make_reader(BytesIO(recording)).iter_messages()
    return [channel.topic for _, channel, _ in messages]


def with_mcap(path):
    sights = CameraDetections()
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            sights.take(channel.topic, message.log_time, decoded)
        attachments = {found.name: read_attachment(found) for found in reader.iter_attachments()}
        metadata = {found.name: found.metadata for found in reader.iter_metadata()}
        profile = reader.get_header().profile
    return {**vars(sights), "attachments": attachments, "metadata": metadata, "profile": profile}


def with_rosbags(path):
    sights = CameraDetections()
    with AnyReader([Path(path)]) as reader:
        for connection, log_time, raw in reader.messages():
            sights.take(connection.topic, log_time, reader.deserialize(raw, connection.msgtype))
        durabilities = {
            connection.topic: [profile.durability.name for profile in connection.ext.offered_qos_profiles]
            for connection in reader.connections
        }
    return {**vars(sights), "durabilities": durabilities}


if __name__ == "__main__":
    recording = sys.argv[1]
    print(json.dumps({"mcap": with_mcap(recording), "rosbags": with_rosbags(recording)}))
