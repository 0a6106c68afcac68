//! Degrees of freedom and their names in a log (SNAME).

/// A degree of freedom in body axes: x forward, y to starboard, z down, and the rotations about them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Dof {
    /// Along x.
    Surge,
    /// Along y.
    Sway,
    /// Along z.
    Heave,
    /// About x.
    Roll,
    /// About y.
    Pitch,
    /// About z.
    Yaw,
}

impl Dof {
    /// All six, in the order of ν.
    pub const ALL: [Dof; 6] = [Dof::Surge, Dof::Sway, Dof::Heave, Dof::Roll, Dof::Pitch, Dof::Yaw];
    /// The three of the horizontal plane.
    pub const PLANE: [Dof; 3] = [Dof::Surge, Dof::Sway, Dof::Yaw];

    /// Index in ν.
    pub fn index(self) -> usize {
        self as usize
    }

    /// Name: `surge` …
    pub fn name(self) -> &'static str {
        ["surge", "sway", "heave", "roll", "pitch", "yaw"][self.index()]
    }

    /// Log column of the velocity.
    pub fn velocity(self) -> &'static str {
        ["u", "v", "w", "p", "q", "r"][self.index()]
    }

    /// Log column of the position or angle.
    pub fn position(self) -> &'static str {
        ["x", "y", "z", "phi", "theta", "psi"][self.index()]
    }

    /// Log column of the commanded force or moment.
    pub fn force(self) -> &'static str {
        ["tau_u", "tau_v", "tau_w", "tau_p", "tau_q", "tau_r"][self.index()]
    }

    /// Log column of the force or moment that load cells measure.
    pub fn load(self) -> &'static str {
        ["load_u", "load_v", "load_w", "load_p", "load_q", "load_r"][self.index()]
    }

    /// Whether it is roll, pitch or yaw.
    pub fn is_rotation(self) -> bool {
        self.index() > 2
    }

    /// The degree of freedom of this name.
    pub fn from_name(name: &str) -> Option<Dof> {
        Dof::ALL.into_iter().find(|dof| dof.name() == name)
    }
}
