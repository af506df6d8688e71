//! Definitions of other packages' messages, from their `.msg` files, without comments.

/// By package and name.
pub(super) const DEFINITIONS: [(&str, &str); 17] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"),
    (
        "geometry_msgs/Pose",
        "geometry_msgs/Point position\n\
         geometry_msgs/Quaternion orientation\n",
    ),
    ("geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
    (
        "geometry_msgs/Transform",
        "geometry_msgs/Vector3 translation\n\
         geometry_msgs/Quaternion rotation\n",
    ),
    (
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header\n\
         string child_frame_id\n\
         geometry_msgs/Transform transform\n",
    ),
    ("tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"),
    (
        "nav_msgs/MapMetaData",
        "builtin_interfaces/Time map_load_time\n\
         float32 resolution\n\
         uint32 width\n\
         uint32 height\n\
         geometry_msgs/Pose origin\n",
    ),
    (
        "nav_msgs/OccupancyGrid",
        "std_msgs/Header header\n\
         nav_msgs/MapMetaData info\n\
         int8[] data\n",
    ),
    ("nav_msgs/Path", "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n"),
    ("foxglove_msgs/GeoJSON", "string geojson\n"),
    ("foxglove_msgs/Vector2", "float64 x\nfloat64 y\n"),
    (
        "foxglove_msgs/PackedElementField",
        "string name\n\
         uint32 offset\n\
         uint8 UNKNOWN=0\n\
         uint8 UINT8=1\n\
         uint8 INT8=2\n\
         uint8 UINT16=3\n\
         uint8 INT16=4\n\
         uint8 UINT32=5\n\
         uint8 INT32=6\n\
         uint8 FLOAT32=7\n\
         uint8 FLOAT64=8\n\
         uint8 type\n",
    ),
    (
        "foxglove_msgs/Grid",
        "builtin_interfaces/Time timestamp\n\
         string frame_id\n\
         geometry_msgs/Pose pose\n\
         uint32 column_count\n\
         foxglove_msgs/Vector2 cell_size\n\
         uint32 row_stride\n\
         uint32 cell_stride\n\
         foxglove_msgs/PackedElementField[] fields\n\
         uint8[] data\n",
    ),
];
