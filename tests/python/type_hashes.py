"""Prints as JSON what rosbags takes for the type hashes (RIHS01) of messages.

Usage: type_hashes.py < {"name": "its ros2msg schema", ...}

Of messages that ROS 2 Jazzy comes with, rosbags has its own definitions; only of others it takes ours.
"""

import json
import sys

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

schemas = json.load(sys.stdin)
store = get_typestore(Stores.ROS2_JAZZY)
known = set(store.fielddefs)
for name, schema in schemas.items():
    types = get_types_from_msg(schema, name)
    store.register({other: fields for other, fields in types.items() if other not in known})
print(json.dumps({name: {"hash": store.hash_rihs01(name), "known": name in known} for name in schemas}))
