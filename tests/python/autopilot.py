"""An autopilot with simple dynamics, by pymavlink: a rover of ArduPilot, its pilot, and a detector on it.

Arguments: the port of the robot, that of its detections, latitude and longitude of the map's south-western corner, meters
east and north of it of the object, and the share of messages that is lost in each direction. It plays what happens to a
vehicle in the field, prints a line for each part that went well, and ends when standard input closes. The radio loses
messages and delays some, so that they overtake each other.

Each message of the robot is decoded and encoded again by pymavlink: the bytes must be the same. The robot must never
steer a vehicle whose heartbeat said that it is not the robot's.
"""

import heapq
import json
import math
import random
import select
import socket
import statistics
import sys
import time

from pymavlink.dialects.v20 import common as mavlink

METERS_PER_DEGREE = 111_320.0
MANUAL, HOLD, RTL, GUIDED = 0, 4, 11, 15
NOT_POSITION = 0b111
FRAME_SECONDS = 0.1
# How fast it turns on the spot, radians a second.
TURN = 1.0
# Time in which what was sent before a heartbeat may still arrive.
GRACE_SECONDS = 0.5
LIMIT_SECONDS = 240.0
CAMERA_YAWS_DEGREES = [0.0, 120.0, -120.0]
WIDTH_PIXELS, HEIGHT_PIXELS, FIELD_OF_VIEW_DEGREES, RANGE_METERS = 1000, 600, 125.0, 35.0


class Radio:
    """A UDP socket that loses messages and lets some overtake others."""

    def __init__(self, port, loss):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect(("127.0.0.1", port))
        self.loss, self.random, self.late = loss, random.Random(1), []

    def send(self, data):
        """Whether it arrives."""
        if self.random.random() < self.loss:
            return False
        delay = self.random.choice([0.0, 0.0, 0.0, 0.0, 0.06]) if self.loss else 0.0
        heapq.heappush(self.late, (time.monotonic() + delay, self.random.random(), data))
        self.flush()
        return True

    def flush(self):
        while self.late and self.late[0][0] <= time.monotonic():
            try:
                self.socket.send(heapq.heappop(self.late)[2])
            except ConnectionRefusedError:
                pass  # The robot is not there yet.

    def receive(self):
        try:
            data = self.socket.recv(65536)
        except ConnectionRefusedError:
            return b""
        return b"" if self.random.random() < self.loss else data


class Rover:
    def __init__(self, radio, detections, corner, thing):
        self.radio, self.detections, self.corner, self.object = radio, detections, corner, thing
        self.x, self.y, self.heading = 30.0, 30.0, 0.0
        self.home = (self.x, self.y)
        self.speed, self.pilot = 8.0, (0.0, 0.0)
        self.battery, self.breach = 90, 0
        self.parser = mavlink.MAVLink(None)
        self.encoder = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self.checked, self.texts, self.commands, self.latencies = 0, [], [], []
        self.mode, self.armed = MANUAL, False
        self.told = None
        self.targets = []
        self.located = None
        self.boot()

    def boot(self):
        # It forgets what it was asked for.
        self.booted, self.rates, self.due, self.target = time.monotonic(), {}, {}, None

    def boot_ms(self):
        return int((time.monotonic() - self.booted) * 1000) + 1

    def switch(self, mode, armed=True):
        if mode != self.mode:
            self.target = None
        self.mode, self.armed, self.told, self.targets = mode, armed, None, []
        self.heartbeat()

    def heartbeat(self):
        flags = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        flags |= mavlink.MAV_MODE_FLAG_SAFETY_ARMED if self.armed else 0
        message = mavlink.MAVLink_heartbeat_message(
            mavlink.MAV_TYPE_GROUND_ROVER, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, flags, self.mode,
            mavlink.MAV_STATE_ACTIVE, 3)
        if self.send(message) and self.told is None:
            self.told = time.monotonic()

    def send(self, message):
        return self.radio.send(message.pack(self.encoder))

    def degrees(self, x, y):
        latitude = self.corner[0] + y / METERS_PER_DEGREE
        return latitude, self.corner[1] + x / METERS_PER_DEGREE / math.cos(math.radians(self.corner[0]))

    def message(self, number):
        latitude, longitude = [round(degrees * 1e7) for degrees in self.degrees(self.x, self.y)]
        yaw = math.pi / 2 - self.heading
        if number == mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT:
            hundredths = round(math.degrees(yaw) % 360 * 100) % 36000
            return mavlink.MAVLink_global_position_int_message(
                self.boot_ms(), latitude, longitude, 50_000, 0, 0, 0, 0, hundredths)
        if number == mavlink.MAVLINK_MSG_ID_ATTITUDE:
            return mavlink.MAVLink_attitude_message(self.boot_ms(), 0, 0, math.remainder(yaw, math.tau), 0, 0, 0)
        if number == mavlink.MAVLINK_MSG_ID_GPS_RAW_INT:
            return mavlink.MAVLink_gps_raw_int_message(
                0, 6, latitude, longitude, 50_000, 80, 120, 0, 0, 14, 0, 500, 800, 100, 0, 0)
        if number == mavlink.MAVLINK_MSG_ID_SYS_STATUS:
            return mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 12000, 100, self.battery, 0, 0, 0, 0, 0, 0)
        if number == mavlink.MAVLINK_MSG_ID_FENCE_STATUS:
            kind = mavlink.FENCE_BREACH_BOUNDARY if self.breach else mavlink.FENCE_BREACH_NONE
            return mavlink.MAVLink_fence_status_message(self.breach, 0, kind, 0, 0)
        if number == mavlink.MAVLINK_MSG_ID_SYSTEM_TIME:
            return mavlink.MAVLink_system_time_message(int(time.time() * 1e6), self.boot_ms())
        return None

    def hear(self, data):
        for message in self.parser.parse_buffer(data) or []:
            self.check(message, data)
            self.obey(message)

    def check(self, message, data):
        assert message.get_type() != "BAD_DATA", message
        assert (message.get_srcSystem(), message.get_srcComponent()) == (1, 191), message
        # Texts as bytes, where there are any.
        fields = [getattr(message, f"_{name}_raw", getattr(message, name)) for name in message.fieldnames]
        again = type(message)(*fields)
        encoder = mavlink.MAVLink(None, srcSystem=1, srcComponent=191)
        encoder.seq = message.get_seq()
        assert again.pack(encoder) == bytes(message.get_msgbuf()), message
        self.checked += 1

    def obey(self, message):
        kind = message.get_type()
        steers = kind in ("SET_POSITION_TARGET_GLOBAL_INT", "SET_POSITION_TARGET_LOCAL_NED")
        if kind == "COMMAND_LONG":
            command = message.command
            if command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
                self.rates[int(message.param1)] = message.param2 / 1e6
            elif command == mavlink.MAV_CMD_REQUEST_MESSAGE:
                latitude, longitude = [round(degrees * 1e7) for degrees in self.degrees(*self.home)]
                self.send(mavlink.MAVLink_home_position_message(
                    latitude, longitude, 50_000, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0))
            else:
                assert command == mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH, message
                self.commands.append(command)
                steers = True
            self.send(mavlink.MAVLink_command_ack_message(command, mavlink.MAV_RESULT_ACCEPTED))
        elif kind == "STATUSTEXT":
            self.texts.append(message.text)
        elif kind == "PARAM_REQUEST_READ":
            values = {"FENCE_ENABLE": 1, "FENCE_TYPE": 2, "FENCE_RADIUS": 500, "FENCE_ALT_MAX": 100}
            self.send(mavlink.MAVLink_param_value_message(
                message.param_id.encode(), values[message.param_id], mavlink.MAV_PARAM_TYPE_REAL32, 4, 0))
        if not steers:
            return
        if not (self.mode == GUIDED and self.armed):
            late = self.told is None or time.monotonic() - self.told < GRACE_SECONDS
            assert late, f"the robot steers in mode {self.mode}, armed {self.armed}: {message}"
            return
        if kind == "SET_POSITION_TARGET_GLOBAL_INT":
            self.aim(message)
        elif kind == "COMMAND_LONG":
            self.switch(RTL)

    def aim(self, message):
        assert message.type_mask & NOT_POSITION == 0, message
        assert message.coordinate_frame == mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, message
        y = (message.lat_int / 1e7 - self.corner[0]) * METERS_PER_DEGREE
        x = (message.lon_int / 1e7 - self.corner[1]) * METERS_PER_DEGREE * math.cos(math.radians(self.corner[0]))
        if self.target is None or math.dist((x, y), self.target) > 1.0:
            if self.target is not None and self.located is not None:
                self.latencies.append(time.monotonic() - self.located)
        self.target = (x, y)
        self.targets.append(self.target)

    def drive(self, seconds):
        goal = {GUIDED: self.target, RTL: self.home}.get(self.mode) if self.armed else None
        if self.mode == MANUAL and self.armed:
            goal = (self.x + self.pilot[0], self.y + self.pilot[1])
        if goal is None:
            return
        distance = math.dist((self.x, self.y), goal)
        if distance < 0.1:
            return
        off = math.remainder(math.atan2(goal[1] - self.y, goal[0] - self.x) - self.heading, math.tau)
        self.heading += max(-TURN * seconds, min(TURN * seconds, off))
        if abs(off) > 0.2:
            return
        share = min(1.0, self.speed * seconds / distance)
        self.x += share * (goal[0] - self.x)
        self.y += share * (goal[1] - self.y)

    def look(self):
        focal = WIDTH_PIXELS / 2 / math.tan(math.radians(FIELD_OF_VIEW_DEGREES / 2))
        distance = math.dist((self.x, self.y), self.object)
        bearing = math.atan2(self.object[1] - self.y, self.object[0] - self.x) - self.heading
        for number, yaw in enumerate(CAMERA_YAWS_DEGREES):
            right = math.remainder(math.radians(yaw) - bearing, math.tau)
            boxes = []
            if 1.0 < distance < RANGE_METERS and abs(right) < math.radians(FIELD_OF_VIEW_DEGREES / 2 - 1):
                column = WIDTH_PIXELS / 2 + focal * math.tan(right)
                boxes = [{"left": max(0.0, column - 5), "right": min(WIDTH_PIXELS, column + 5), "top": 280.0,
                          "bottom": 320.0, "class": "person", "score": 0.9}]
            sighting = {"camera": f"camera_{number}", "unix_seconds": time.time(), "boxes": boxes}
            try:
                self.detections.send(json.dumps(sighting).encode())
            except ConnectionRefusedError:
                pass

    def run(self, seconds):
        """Lives for this time."""
        before = time.monotonic()
        end = before + seconds
        while (now := time.monotonic()) < end:
            self.radio.flush()
            self.drive(now - before)
            before = now
            for what in [*self.rates, "heartbeat", "frame"]:
                if now < self.due.get(what, 0.0):
                    continue
                if what == "heartbeat":
                    self.due[what] = now + 1.0
                    self.heartbeat()
                elif what == "frame":
                    self.due[what] = now + FRAME_SECONDS
                    self.look()
                elif message := self.message(what):
                    self.due[what] = now + self.rates[what]
                    if self.send(message) and what == mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT:
                        self.located = time.monotonic()
            if select.select([self.radio.socket], [], [], 0.005)[0]:
                self.hear(self.radio.receive())

    def until(self, what, is_so):
        end = time.monotonic() + LIMIT_SECONDS
        while not is_so():
            assert time.monotonic() < end, f"in vain until {what}: {vars(self)}"
            self.run(0.05)


def play(rover):
    """What happens to a vehicle in the field. That the robot does not steer meanwhile is checked with each message."""
    def goes():
        start = (rover.x, rover.y)
        rover.until("it drives", lambda: math.dist(start, (rover.x, rover.y)) > 5.0)

    def waits(seconds):
        rover.run(seconds)
        rover.until("its heartbeat arrives", lambda: rover.told is not None)
        rover.run(2.0)

    def stays():
        place = (rover.x, rover.y)
        rover.run(2.0)
        return math.dist(place, (rover.x, rover.y)) < 0.2

    rover.until("the robot is there", lambda: rover.checked > 0)
    waits(1.0)
    rover.switch(GUIDED)
    goes()
    yield "armed by its pilot it drives"

    rover.pilot = (0.0, 1.0) if rover.y < 60.0 else (0.0, -1.0)
    rover.switch(MANUAL)
    waits(2.0)
    rover.switch(GUIDED)
    goes()
    yield "a pilot took over and gave it back"

    rover.switch(RTL)
    waits(2.0)
    rover.switch(GUIDED)
    goes()
    yield "it returned and came back"

    # The autopilot is silent while it starts again.
    time.sleep(1.0)
    while select.select([rover.radio.socket], [], [], 0)[0]:
        rover.radio.receive()
    rover.boot()
    rover.switch(HOLD, armed=False)
    waits(2.0)
    rover.switch(GUIDED)
    goes()
    yield "the autopilot started again"

    rover.breach, rover.targets = 1, []
    rover.until("it is told to stay", lambda: rover.targets and math.dist(rover.targets[-1], (rover.x, rover.y)) < 3.0)
    rover.until("it stays", stays)
    rover.breach = 0
    goes()
    yield "it held while its fence was breached"

    for rover.battery in range(rover.battery, 10, -15):
        rover.run(1.5)
    rover.until("it is sent home", lambda: rover.mode == RTL)
    waits(1.0)
    rover.battery = 95
    while rover.mode == RTL:
        # A charge that jumps is not believed at once.
        rover.run(3.0)
        rover.switch(GUIDED)
        start = (rover.x, rover.y)
        rover.until("it drives", lambda: rover.mode == RTL or math.dist(start, (rover.x, rover.y)) > 5.0)
    yield "a low battery sent it home, a new one back"


def main():
    port, detections_port = int(sys.argv[1]), int(sys.argv[2])
    latitude, longitude, x, y, loss = map(float, sys.argv[3:8])
    detections = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    detections.connect(("127.0.0.1", detections_port))
    rover = Rover(Radio(port, loss), detections, (latitude, longitude), (x, y))
    for part in play(rover):
        print(part, flush=True)
    rover.speed = 12.0
    print("the rest is the robot's", flush=True)
    while not select.select([sys.stdin], [], [], 0)[0]:
        rover.run(0.2)
    assert any(text.startswith("dragnet: ") for text in rover.texts), rover.texts
    milliseconds = sorted(1000 * latency for latency in rover.latencies)
    print(f"{rover.checked} messages are the bytes of pymavlink; from a position to the next target "
          f"{statistics.median(milliseconds):.1f} ms, at most {milliseconds[-1]:.1f} ms, "
          f"{len(milliseconds)} targets", flush=True)


main()
