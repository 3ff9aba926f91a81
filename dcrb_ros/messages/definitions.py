"""The definitions of the ROS messages that the package writes and reads, those of Jazzy.

The type store of rosbags has all 162 types of Jazzy. To make classes of them takes 0.09 s of every start, to read these 0.02 s.
"""

DEFINITIONS = {
    "std_msgs/Header": "builtin_interfaces/Time stamp; string frame_id",
    "std_msgs/Float64": "float64 data",
    "std_msgs/String": "string data",
    "rosgraph_msgs/Clock": "builtin_interfaces/Time clock",
    "diagnostic_msgs/KeyValue": "string key; string value",
    "diagnostic_msgs/DiagnosticStatus": (
        "byte OK=0; byte WARN=1; byte ERROR=2; byte STALE=3; byte level; string name; string message; string hardware_id; "
        "diagnostic_msgs/KeyValue[] values"
    ),
    "diagnostic_msgs/DiagnosticArray": "std_msgs/Header header; diagnostic_msgs/DiagnosticStatus[] status",
    "geometry_msgs/Point": "float64 x; float64 y; float64 z",
    "geometry_msgs/Quaternion": "float64 x; float64 y; float64 z; float64 w",
    "geometry_msgs/Vector3": "float64 x; float64 y; float64 z",
    "geometry_msgs/Pose": "geometry_msgs/Point position; geometry_msgs/Quaternion orientation",
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose; float64[36] covariance",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation; geometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": "std_msgs/Header header; string child_frame_id; geometry_msgs/Transform transform",
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear; geometry_msgs/Vector3 angular",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist; float64[36] covariance",
    "geometry_msgs/Wrench": "geometry_msgs/Vector3 force; geometry_msgs/Vector3 torque",
    "nav_msgs/Odometry": (
        "std_msgs/Header header; string child_frame_id; geometry_msgs/PoseWithCovariance pose; geometry_msgs/TwistWithCovariance twist"
    ),
    "sensor_msgs/Imu": (
        "std_msgs/Header header; geometry_msgs/Quaternion orientation; float64[9] orientation_covariance; "
        "geometry_msgs/Vector3 angular_velocity; float64[9] angular_velocity_covariance; "
        "geometry_msgs/Vector3 linear_acceleration; float64[9] linear_acceleration_covariance"
    ),
    "sensor_msgs/JointState": "std_msgs/Header header; string[] name; float64[] position; float64[] velocity; float64[] effort",
    "sensor_msgs/PointField": (
        "uint8 INT8=1; uint8 UINT8=2; uint8 INT16=3; uint8 UINT16=4; uint8 INT32=5; uint8 UINT32=6; uint8 FLOAT32=7; "
        "uint8 FLOAT64=8; string name; uint32 offset; uint8 datatype; uint32 count"
    ),
    "sensor_msgs/PointCloud2": (
        "std_msgs/Header header; uint32 height; uint32 width; sensor_msgs/PointField[] fields; bool is_bigendian; "
        "uint32 point_step; uint32 row_step; uint8[] data; bool is_dense"
    ),
    "sensor_msgs/Temperature": "std_msgs/Header header; float64 temperature; float64 variance",
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
}
"""Fields and constants of each type, separated by semicolons."""
