//! Definitions of the messages on a robot's own ROS 2 network, from ROS 2 Jazzy, without comments.

/// By package and name.
pub(super) const DEFINITIONS: [(&str, &str); 30] = [
    ("geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"),
    (
        "geometry_msgs/PoseWithCovarianceStamped",
        "std_msgs/Header header\n\
         geometry_msgs/PoseWithCovariance pose\n",
    ),
    ("geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"),
    ("geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"),
    (
        "nav_msgs/Odometry",
        "std_msgs/Header header\n\
         string child_frame_id\n\
         geometry_msgs/PoseWithCovariance pose\n\
         geometry_msgs/TwistWithCovariance twist\n",
    ),
    (
        "sensor_msgs/NavSatStatus",
        "int8 STATUS_UNKNOWN=-2\n\
         int8 STATUS_NO_FIX=-1\n\
         int8 STATUS_FIX=0\n\
         int8 STATUS_SBAS_FIX=1\n\
         int8 STATUS_GBAS_FIX=2\n\
         int8 status\n\
         uint16 SERVICE_UNKNOWN=0\n\
         uint16 SERVICE_GPS=1\n\
         uint16 SERVICE_GLONASS=2\n\
         uint16 SERVICE_COMPASS=4\n\
         uint16 SERVICE_GALILEO=8\n\
         uint16 service\n",
    ),
    (
        "sensor_msgs/NavSatFix",
        "std_msgs/Header header\n\
         sensor_msgs/NavSatStatus status\n\
         float64 latitude\n\
         float64 longitude\n\
         float64 altitude\n\
         float64[9] position_covariance\n\
         uint8 COVARIANCE_TYPE_UNKNOWN=0\n\
         uint8 COVARIANCE_TYPE_APPROXIMATED=1\n\
         uint8 COVARIANCE_TYPE_DIAGONAL_KNOWN=2\n\
         uint8 COVARIANCE_TYPE_KNOWN=3\n\
         uint8 position_covariance_type\n",
    ),
    (
        "sensor_msgs/Image",
        "std_msgs/Header header\n\
         uint32 height\n\
         uint32 width\n\
         string encoding\n\
         uint8 is_bigendian\n\
         uint32 step\n\
         uint8[] data\n",
    ),
    ("sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"),
    (
        "sensor_msgs/RegionOfInterest",
        "uint32 x_offset\n\
         uint32 y_offset\n\
         uint32 height\n\
         uint32 width\n\
         bool do_rectify\n",
    ),
    (
        "sensor_msgs/CameraInfo",
        "std_msgs/Header header\n\
         uint32 height\n\
         uint32 width\n\
         string distortion_model\n\
         float64[] d\n\
         float64[9] k\n\
         float64[9] r\n\
         float64[12] p\n\
         uint32 binning_x\n\
         uint32 binning_y\n\
         sensor_msgs/RegionOfInterest roi\n",
    ),
    ("std_msgs/Bool", "bool data\n"),
    (
        "sensor_msgs/BatteryState",
        "uint8 POWER_SUPPLY_STATUS_UNKNOWN=0\n\
         uint8 POWER_SUPPLY_STATUS_CHARGING=1\n\
         uint8 POWER_SUPPLY_STATUS_DISCHARGING=2\n\
         uint8 POWER_SUPPLY_STATUS_NOT_CHARGING=3\n\
         uint8 POWER_SUPPLY_STATUS_FULL=4\n\
         uint8 POWER_SUPPLY_HEALTH_UNKNOWN=0\n\
         uint8 POWER_SUPPLY_HEALTH_GOOD=1\n\
         uint8 POWER_SUPPLY_HEALTH_OVERHEAT=2\n\
         uint8 POWER_SUPPLY_HEALTH_DEAD=3\n\
         uint8 POWER_SUPPLY_HEALTH_OVERVOLTAGE=4\n\
         uint8 POWER_SUPPLY_HEALTH_UNSPEC_FAILURE=5\n\
         uint8 POWER_SUPPLY_HEALTH_COLD=6\n\
         uint8 POWER_SUPPLY_HEALTH_WATCHDOG_TIMER_EXPIRE=7\n\
         uint8 POWER_SUPPLY_HEALTH_SAFETY_TIMER_EXPIRE=8\n\
         uint8 POWER_SUPPLY_TECHNOLOGY_UNKNOWN=0\n\
         uint8 POWER_SUPPLY_TECHNOLOGY_NIMH=1\n\
         uint8 POWER_SUPPLY_TECHNOLOGY_LION=2\n\
         uint8 POWER_SUPPLY_TECHNOLOGY_LIPO=3\n\
         uint8 POWER_SUPPLY_TECHNOLOGY_LIFE=4\n\
         uint8 POWER_SUPPLY_TECHNOLOGY_NICD=5\n\
         uint8 POWER_SUPPLY_TECHNOLOGY_LIMN=6\n\
         uint8 POWER_SUPPLY_TECHNOLOGY_TERNARY=7\n\
         uint8 POWER_SUPPLY_TECHNOLOGY_VRLA=8\n\
         std_msgs/Header header\n\
         float32 voltage\n\
         float32 temperature\n\
         float32 current\n\
         float32 charge\n\
         float32 capacity\n\
         float32 design_capacity\n\
         float32 percentage\n\
         uint8 power_supply_status\n\
         uint8 power_supply_health\n\
         uint8 power_supply_technology\n\
         bool present\n\
         float32[] cell_voltage\n\
         float32[] cell_temperature\n\
         string location\n\
         string serial_number\n",
    ),
    ("unique_identifier_msgs/UUID", "uint8[16] uuid\n"),
    (
        "action_msgs/GoalInfo",
        "unique_identifier_msgs/UUID goal_id\n\
         builtin_interfaces/Time stamp\n",
    ),
    (
        "action_msgs/GoalStatus",
        "int8 STATUS_UNKNOWN=0\n\
         int8 STATUS_ACCEPTED=1\n\
         int8 STATUS_EXECUTING=2\n\
         int8 STATUS_CANCELING=3\n\
         int8 STATUS_SUCCEEDED=4\n\
         int8 STATUS_CANCELED=5\n\
         int8 STATUS_ABORTED=6\n\
         action_msgs/GoalInfo goal_info\n\
         int8 status\n",
    ),
    ("action_msgs/GoalStatusArray", "action_msgs/GoalStatus[] status_list\n"),
    ("diagnostic_msgs/KeyValue", "string key\nstring value\n"),
    (
        "diagnostic_msgs/DiagnosticStatus",
        "byte OK=0\n\
         byte WARN=1\n\
         byte ERROR=2\n\
         byte STALE=3\n\
         byte level\n\
         string name\n\
         string message\n\
         string hardware_id\n\
         diagnostic_msgs/KeyValue[] values\n",
    ),
    (
        "diagnostic_msgs/DiagnosticArray",
        "std_msgs/Header header\n\
         diagnostic_msgs/DiagnosticStatus[] status\n",
    ),
    ("vision_msgs/Point2D", "float64 x\nfloat64 y\n"),
    ("vision_msgs/Pose2D", "vision_msgs/Point2D position\nfloat64 theta\n"),
    ("vision_msgs/BoundingBox2D", "vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y\n"),
    ("vision_msgs/ObjectHypothesis", "string class_id\nfloat64 score\n"),
    (
        "vision_msgs/ObjectHypothesisWithPose",
        "vision_msgs/ObjectHypothesis hypothesis\n\
         geometry_msgs/PoseWithCovariance pose\n",
    ),
    (
        "vision_msgs/Detection2D",
        "std_msgs/Header header\n\
         vision_msgs/ObjectHypothesisWithPose[] results\n\
         vision_msgs/BoundingBox2D bbox\n\
         string id\n",
    ),
    ("vision_msgs/Detection2DArray", "std_msgs/Header header\nvision_msgs/Detection2D[] detections\n"),
    ("vision_msgs/BoundingBox3D", "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size\n"),
    (
        "vision_msgs/Detection3D",
        "std_msgs/Header header\n\
         vision_msgs/ObjectHypothesisWithPose[] results\n\
         vision_msgs/BoundingBox3D bbox\n\
         string id\n",
    ),
    ("vision_msgs/Detection3DArray", "std_msgs/Header header\nvision_msgs/Detection3D[] detections\n"),
];
