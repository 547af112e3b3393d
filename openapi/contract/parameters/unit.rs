//! The unit of a field, which its name ends with.

/// Endings of names, longest first where one ends with another.
const UNITS: [(&str, &str); 14] = [
    ("_rad_per_s2", "rad/s²"),
    ("_m_per_s2", "m/s²"),
    ("_rad_per_s", "rad/s"),
    ("_m_per_s", "m/s"),
    ("_per_s", "1/s"),
    ("_m_per_rad", "m/rad"),
    ("_s_per_m", "s/m"),
    ("_rad2", "rad²"),
    ("_m2", "m²"),
    ("_rad", "rad"),
    ("_slots", "slots"),
    ("_s", "s"),
    ("_m", "m"),
    ("_probability", "1"),
];

/// The unit that `name` ends with; nothing for what has none.
pub fn unit(name: &str) -> &'static str {
    UNITS.iter().find(|(ending, _)| name.ends_with(ending)).map_or("", |(_, unit)| unit)
}

#[test]
fn the_longest_ending_counts() {
    assert_eq!(unit("max_angular_acceleration_rad_per_s2"), "rad/s²");
    assert_eq!(unit("rate_per_s"), "1/s");
    assert_eq!((unit("sideways_m_per_rad"), unit("turn_by_speed_s_per_m")), ("m/rad", "s/m"));
    assert_eq!(unit("horizon_slots"), "slots");
    assert_eq!(unit("rotations"), "");
}
