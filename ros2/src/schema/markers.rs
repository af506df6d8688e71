//! Definitions of markers, from ROS 2's `.msg` files, without comments.

/// By package and name.
pub(super) const DEFINITIONS: [(&str, &str); 5] = [
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n"),
    ("std_msgs/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"),
    ("visualization_msgs/UVCoordinate", "float32 u\nfloat32 v\n"),
    ("visualization_msgs/MeshFile", "string filename\nuint8[] data\n"),
    (
        "visualization_msgs/Marker",
        "int32 ARROW=0\n\
         int32 CUBE=1\n\
         int32 SPHERE=2\n\
         int32 CYLINDER=3\n\
         int32 LINE_STRIP=4\n\
         int32 LINE_LIST=5\n\
         int32 CUBE_LIST=6\n\
         int32 SPHERE_LIST=7\n\
         int32 POINTS=8\n\
         int32 TEXT_VIEW_FACING=9\n\
         int32 MESH_RESOURCE=10\n\
         int32 TRIANGLE_LIST=11\n\
         int32 ARROW_STRIP=12\n\
         int32 ADD=0\n\
         int32 MODIFY=0\n\
         int32 DELETE=2\n\
         int32 DELETEALL=3\n\
         std_msgs/Header header\n\
         string ns\n\
         int32 id\n\
         int32 type\n\
         int32 action\n\
         geometry_msgs/Pose pose\n\
         geometry_msgs/Vector3 scale\n\
         std_msgs/ColorRGBA color\n\
         builtin_interfaces/Duration lifetime\n\
         bool frame_locked\n\
         geometry_msgs/Point[] points\n\
         std_msgs/ColorRGBA[] colors\n\
         string texture_resource\n\
         sensor_msgs/CompressedImage texture\n\
         visualization_msgs/UVCoordinate[] uv_coordinates\n\
         string text\n\
         string mesh_resource\n\
         visualization_msgs/MeshFile mesh_file\n\
         bool mesh_use_embedded_materials\n",
    ),
];
