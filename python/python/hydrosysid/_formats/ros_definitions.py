"""Definitions of ROS messages that vehicles log and that neither their bags nor `rosbags` hold.

Bags of ROS 2 before Iron have no definitions. A type stands here once for each layout that was released; the one that
a message fills to its last byte is its own. Field lists of mavros_msgs 2, of the drivers of the Water Linked A50 and of
marine_acoustic_msgs 2.
"""

HEADER = "std_msgs/Header header\n"
_CHANNELS = HEADER + "uint16[] channels\n"
_SERVOS = "".join(f"uint16 servo{k}_raw\n" for k in range(1, 17))
_HUD = (
    HEADER + "float32 airspeed\nfloat32 groundspeed\nint16 heading\nfloat32 throttle\nfloat32 altitude\nfloat32 climb\n"
)
_MOTION = HEADER + "uint8 coordinate_frame\nuint16 type_mask\n"
_WATER_LINKED = HEADER + "float64 time\ngeometry_msgs/Vector3 velocity\nfloat64 fom\n"
_BEAMS = "float64 altitude\nDVLBeam[] beams\nbool velocity_valid\nint64 status\n"
_FOUR_BEAMS = _BEAMS.replace("[]", "[4]") + "int64 time_of_validity\nint64 time_of_transmission\n"
_BEAM = "int64 id\nfloat64 velocity\nfloat64 distance\nfloat64 rssi\nfloat64 nsd\nbool valid\n"
_RECKONED = (
    HEADER
    + "float64 time\ngeometry_msgs/Vector3 position\nfloat64 pos_std\nfloat64 roll\nfloat64 pitch\nfloat64 yaw\n"
    + "string type\nint64 status\nstring format\n"
)

DEFINITIONS: dict[str, tuple[str, ...]] = {
    "mavros_msgs/msg/RCOut": (_CHANNELS,),
    "mavros_msgs/msg/RCIn": (HEADER + "uint8 rssi\nuint16[] channels\n",),
    "mavros_msgs/msg/OverrideRCIn": ("uint16[18] channels\n", "uint16[8] channels\n"),
    "mavros_msgs/msg/ServoOutputRaw": (HEADER + "uint8 port\n" + _SERVOS,),
    "mavros_msgs/msg/ManualControl": (HEADER + "float32 x\nfloat32 y\nfloat32 z\nfloat32 r\nuint16 buttons\n",),
    "mavros_msgs/msg/ActuatorControl": (HEADER + "uint8 group_mix\nfloat32[8] controls\n",),
    "mavros_msgs/msg/State": (
        HEADER + "bool connected\nbool armed\nbool guided\nbool manual_input\nstring mode\nuint8 system_status\n",
    ),
    "mavros_msgs/msg/VfrHud": (_HUD,),
    "mavros_msgs/msg/VFRHUD": (_HUD,),
    "mavros_msgs/msg/Altitude": (
        HEADER
        + "float32 monotonic\nfloat32 amsl\nfloat32 local\nfloat32 relative\nfloat32 terrain\n"
        + "float32 bottom_clearance\n",
    ),
    "mavros_msgs/msg/AttitudeTarget": (
        HEADER
        + "uint8 type_mask\ngeometry_msgs/Quaternion orientation\ngeometry_msgs/Vector3 body_rate\nfloat32 thrust\n",
    ),
    "mavros_msgs/msg/PositionTarget": (
        _MOTION
        + "geometry_msgs/Point position\ngeometry_msgs/Vector3 velocity\ngeometry_msgs/Vector3 acceleration_or_force\n"
        + "float32 yaw\nfloat32 yaw_rate\n",
    ),
    "mavros_msgs/msg/SysStatus": (
        HEADER
        + "uint32 sensors_present\nuint32 sensors_enabled\nuint32 sensors_health\nuint16 load\nuint16 voltage_battery\n"
        + "int16 current_battery\nint8 battery_remaining\nuint16 drop_rate_comm\nuint16 errors_comm\n"
        + "".join(f"uint16 errors_count{k}\n" for k in range(1, 5)),
    ),
    "mavros_msgs/msg/ESCTelemetry": (HEADER + "ESCTelemetryItem[] esc_telemetry\n",),
    "mavros_msgs/msg/ESCTelemetryItem": (
        HEADER
        + "float32 temperature\nfloat32 voltage\nfloat32 current\nfloat32 totalcurrent\nint32 rpm\nuint16 count\n",
    ),
    "marine_acoustic_msgs/msg/Dvl": (
        HEADER
        + "uint8 velocity_mode\nuint8 dvl_type\ngeometry_msgs/Vector3 velocity\nfloat64[9] velocity_covar\n"
        + "float64 altitude\nfloat64 course_gnd\nfloat64 speed_gnd\nuint8 num_good_beams\nfloat32 sound_speed\n"
        + "bool beam_ranges_valid\nbool beam_velocities_valid\ngeometry_msgs/Vector3[4] beam_unit_vec\n"
        + "float64[4] range\nfloat32[4] range_covar\nfloat32[4] beam_quality\nfloat32[4] beam_velocity\n"
        + "float32[4] beam_velocity_covar\n",
    ),
}
for _package in ("dvl_msgs", "rov_msgs", "waterlinked_a50_ros_driver", "dvl_a50"):
    DEFINITIONS |= {
        f"{_package}/msg/DVL": (
            _WATER_LINKED + _BEAMS + "string form\n",
            _WATER_LINKED + "float64[9] covariance\n" + _BEAMS + "string form\n",
            _WATER_LINKED + "float64[9] covariance\n" + _FOUR_BEAMS + "string form\n",
        ),
        f"{_package}/msg/DVLBeam": (_BEAM,),
        f"{_package}/msg/DVLDR": (_RECKONED, _RECKONED + "string child_frame_id\n"),
    }
