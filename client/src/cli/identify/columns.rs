//! Which cells of a row say what, by the header.

/// What poses need.
pub(super) const POSES: &str = "poses have the columns t_s, x_m, y_m, heading_rad";

/// What commands need.
pub(super) const COMMANDS: &str = "commands have the columns t_s, linear_m_per_s, angular_rad_per_s or t_s, left_rad_per_s, \
                                   right_rad_per_s";

const TIME: &str = "t_s";
const POSE: [&str; 3] = ["x_m", "y_m", "heading_rad"];
const WHEELS: [&str; 2] = ["left_rad_per_s", "right_rad_per_s"];
const TWIST: [&str; 2] = ["linear_m_per_s", "angular_rad_per_s"];
/// Those of a twist without their units.
const BARE: [&str; 2] = ["linear", "angular"];

/// A column: its name and its place in a row.
pub(super) type Column = (&'static str, usize);

/// The columns of a file.
pub(super) struct Columns {
    pub(super) time: Column,
    pub(super) pose: Option<[Column; 3]>,
    pub(super) wheels: Option<[Column; 2]>,
    pub(super) twist: Option<[Column; 2]>,
}

impl Columns {
    /// Reads a header; what is wrong with it otherwise.
    pub(super) fn read(header: &str) -> Result<Self, String> {
        let cells: Vec<&str> = cells(header).collect();
        if cells.iter().any(|cell| cell.parse::<f64>().is_ok()) {
            return Err(format!("this is no header: begin with one; {POSES}, {COMMANDS}"));
        }
        let find = |name: &'static str| {
            cells.iter().position(|cell| *cell == name).map(|place| (name, place))
        };
        let pose = all(POSE, find)?;
        let wheels = all(WHEELS, find)?;
        // With units and without, mixed as they may be.
        let twist = [0, 1].map(|it| find(TWIST[it]).or_else(|| find(BARE[it])));
        let twist = whole(TWIST, twist)?;
        if pose.is_none() && wheels.is_none() && twist.is_none() {
            return Err(format!("neither poses nor commands in this header; {POSES}, {COMMANDS}"));
        }
        let time = find(TIME).ok_or("there is no column t_s: add the time in s to every row")?;
        Ok(Self { time, pose, wheels, twist })
    }
}

/// The cells of a row, without spaces and quotes around them.
pub(super) fn cells(row: &str) -> impl Iterator<Item = &str> {
    row.split(',').map(|cell| cell.trim().trim_matches('"').trim())
}

fn all<const N: usize>(
    names: [&'static str; N],
    find: impl Fn(&'static str) -> Option<Column>,
) -> Result<Option<[Column; N]>, String> {
    whole(names, names.map(find))
}

/// All columns of these names, or none of them.
fn whole<const N: usize>(
    names: [&'static str; N],
    found: [Option<Column>; N],
) -> Result<Option<[Column; N]>, String> {
    if found.iter().all(Option::is_none) {
        return Ok(None);
    }
    let missing: Vec<&str> =
        names.into_iter().zip(found).filter(|it| it.1.is_none()).map(|it| it.0).collect();
    if !missing.is_empty() {
        let (names, missing) = (names.join(", "), missing.join(", "));
        return Err(format!("there is no column {missing}: {names} belong together"));
    }
    Ok(Some(found.map(Option::unwrap_or_default)))
}
