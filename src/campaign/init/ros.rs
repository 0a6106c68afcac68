//! Tables of ROS messages: the columns have the names of the fields, and the axes are those of
//! REP 103.

/// Parts of names that only a table of messages has in its header.
const SIGNATURES: [&str; 4] = ["header.stamp", "pose.pose.", "twist.twist.", "wrench.wrench."];
/// Fields along axes.
const VECTORS: [&str; 8] = [
    "pose.position.",
    "orientation.",
    "twist.linear.",
    "twist.angular.",
    "angular_velocity.",
    "linear_acceleration.",
    "wrench.force.",
    "wrench.torque.",
];

/// Whether a name occurs only in the header of a table of messages.
fn is_signed(header: &str) -> bool {
    let name = plain(header);
    name == "%time" || name.starts_with("field.") || SIGNATURES.iter().any(|s| name.contains(s))
}

fn plain(header: &str) -> String {
    header.to_lowercase().replace('/', ".")
}

/// Name of the velocity along the last axis in a table of messages of a DVL, which has axes of its
/// own.
pub fn of_dvl(headers: &[String]) -> Option<&str> {
    let is_velocity = |header: &&String| {
        let name = plain(header);
        name == "velocity.z" || name.ends_with(".velocity.z")
    };
    headers.iter().any(|h| is_signed(h)).then(|| headers.iter().find(is_velocity))?.map(String::as_str)
}

/// The first column along an axis if the header is that of ROS messages, as `rostopic echo -p` and
/// exporters write them.
pub fn field(headers: &[String]) -> Option<&str> {
    let is_vector = |header: &&String| VECTORS.iter().any(|v| plain(header).contains(v));
    headers.iter().any(|h| is_signed(h)).then(|| headers.iter().find(is_vector))?.map(String::as_str)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_messages_are_told_from_names_with_points() {
        let of = |text: &str| field(&text.split(',').map(str::to_string).collect::<Vec<_>>()).map(str::to_string);
        for (header, wanted) in [
            ("%time,field.twist.twist.linear.x", Some("field.twist.twist.linear.x")),
            ("header.stamp.secs,angular_velocity.z", Some("angular_velocity.z")),
            ("t,/odom/pose/pose/position/x", Some("/odom/pose/pose/position/x")),
            ("%time,field.channels0", None),
            ("stamp,imu.angular_velocity.z,dvl.velocity.x", None),
            ("t,u,v,r", None),
        ] {
            assert_eq!(of(header).as_deref(), wanted, "{header}");
        }
    }
}
