//! The standard ROS 2 types that the scene is made of, field by field (common_interfaces, geometry2).

/// A type's definition with those of all types in it.
macro_rules! definition {
    ($main:expr $(, $name:literal: $fields:expr)* $(,)?) => {
        concat!(
            $main,
            $(
                "================================================================================\n",
                "MSG: ", $name, "\n", $fields
            ),*
        )
    };
}

macro_rules! time {
    () => {
        "int32 sec\nuint32 nanosec\n"
    };
}
macro_rules! header {
    () => {
        "builtin_interfaces/Time stamp\nstring frame_id\n"
    };
}
macro_rules! xyz {
    () => {
        "float64 x\nfloat64 y\nfloat64 z\n"
    };
}
macro_rules! quaternion {
    () => {
        "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
    };
}

/// `tf2_msgs/msg/TFMessage`.
pub(super) const TRANSFORMS: &str = definition!(
    "geometry_msgs/TransformStamped[] transforms\n",
    "geometry_msgs/TransformStamped":
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
    "geometry_msgs/Transform":
        "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
    "geometry_msgs/Vector3": xyz!(),
    "geometry_msgs/Quaternion": quaternion!(),
    "std_msgs/Header": header!(),
    "builtin_interfaces/Time": time!(),
);

/// `visualization_msgs/msg/MarkerArray`.
pub(super) const MARKERS: &str = definition!(
    "visualization_msgs/Marker[] markers\n",
    "visualization_msgs/Marker":
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n\
         geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n\
         builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n\
         std_msgs/ColorRGBA[] colors\nstring texture_resource\nsensor_msgs/CompressedImage texture\n\
         visualization_msgs/UVCoordinate[] uv_coordinates\nstring text\nstring mesh_resource\n\
         visualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials\n",
    "visualization_msgs/UVCoordinate": "float32 u\nfloat32 v\n",
    "visualization_msgs/MeshFile": "string filename\nuint8[] data\n",
    "sensor_msgs/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data\n",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
    "geometry_msgs/Point": xyz!(),
    "geometry_msgs/Vector3": xyz!(),
    "geometry_msgs/Quaternion": quaternion!(),
    "std_msgs/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n",
    "std_msgs/Header": header!(),
    "builtin_interfaces/Duration": time!(),
    "builtin_interfaces/Time": time!(),
);

/// `sensor_msgs/msg/PointCloud2`.
pub(super) const POINTS: &str = definition!(
    "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n\
     bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
    "sensor_msgs/PointField": "string name\nuint32 offset\nuint8 datatype\nuint32 count\n",
    "std_msgs/Header": header!(),
    "builtin_interfaces/Time": time!(),
);
