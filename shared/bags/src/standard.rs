//! Definitions of ROS 2's common types, for bags that carry none.
//!
//! The fields follow <https://github.com/ros2/common_interfaces>.

/// Types and their fields.
const TYPES: &[(&str, &str)] = &[
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
    ("geometry_msgs/Accel", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular"),
    ("geometry_msgs/AccelStamped", "std_msgs/Header header\ngeometry_msgs/Accel accel"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/PointStamped", "std_msgs/Header header\ngeometry_msgs/Point point"),
    ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation"),
    ("geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose"),
    ("geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance"),
    (
        "geometry_msgs/PoseWithCovarianceStamped",
        "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose",
    ),
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w"),
    ("geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular"),
    ("geometry_msgs/TwistStamped", "std_msgs/Header header\ngeometry_msgs/Twist twist"),
    ("geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance"),
    (
        "geometry_msgs/TwistWithCovarianceStamped",
        "std_msgs/Header header\ngeometry_msgs/TwistWithCovariance twist",
    ),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/Vector3Stamped", "std_msgs/Header header\ngeometry_msgs/Vector3 vector"),
    (
        "nav_msgs/Odometry",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
         geometry_msgs/TwistWithCovariance twist",
    ),
    (
        "sensor_msgs/Imu",
        "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n\
         float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n\
         float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n\
         float64[9] linear_acceleration_covariance",
    ),
    (
        "sensor_msgs/NavSatFix",
        "std_msgs/Header header\nsensor_msgs/NavSatStatus status\nfloat64 latitude\n\
         float64 longitude\nfloat64 altitude\nfloat64[9] position_covariance\n\
         uint8 position_covariance_type",
    ),
    ("sensor_msgs/NavSatStatus", "int8 status\nuint16 service"),
    ("std_msgs/Float32", "float32 data"),
    ("std_msgs/Float64", "float64 data"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id"),
];

/// Text of the definition of `type_name` with all types that it uses; empty for an unknown type.
pub(crate) fn definition(type_name: &str) -> String {
    let short = type_name.replace("/msg/", "/");
    let Some((_, fields)) = TYPES.iter().find(|(name, _)| *name == short) else {
        return String::new();
    };
    let others: String =
        TYPES.iter().map(|(name, fields)| format!("\n====\nMSG: {name}\n{fields}")).collect();
    format!("{fields}{others}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::definition::{Definition, Kind};

    #[test]
    fn every_type_that_is_used_is_defined() {
        for (name, _) in TYPES {
            let parsed = Definition::parse(name, &definition(name));
            assert!(!parsed.numbers().is_empty(), "{name}");
            for field in parsed.fields(name).expect("the type") {
                if let Kind::Struct(used) = &field.kind {
                    assert!(parsed.fields(used).is_some(), "{name} uses {used}");
                }
            }
        }
        assert_eq!(definition("my_msgs/msg/Speed"), "");
    }

    #[test]
    fn an_odometry_has_its_speed() {
        let numbers =
            Definition::parse("nav_msgs/msg/Odometry", &definition("nav_msgs/msg/Odometry"))
                .numbers();
        assert!(numbers.contains(&"twist.twist.linear.x".to_owned()), "{numbers:?}");
        assert!(numbers.contains(&"header.stamp".to_owned()));
    }
}
