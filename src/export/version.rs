//! Versions of the consumer that can read the file of a target.
//!
//! ```text
//! gz-sim Hydrodynamics    7.0, 7.1: <xUU> only, no couplings    7.2 …: <xUabsU>, couplings
//!                         9 …: added mass in this system is deprecated
//! ```
//!
//! Source: gz-sim, `Hydrodynamics.cc` of 7.1.0, 7.2.0, 8.14 and 9.5.

use super::{ExportError, ExportOptions, Target, codes};
use crate::finding::Finding;

/// Checks the requested version.
///
/// # Errors
/// [`ExportError::Version`] if it is no version number, or the target does not support it.
pub(super) fn check(target: Target, options: &ExportOptions) -> Result<Vec<Finding>, ExportError> {
    let Some(version) = &options.version else { return Ok(Vec::new()) };
    let refused = |reason: String| Err(ExportError::Version { version: version.clone(), reason });
    let Some(first) = target.first_version() else {
        return refused(format!("a file of `{}` is the same for every version: omit --target-version", target.name()));
    };
    let Some(asked) = parsed(version) else {
        return refused("a version of gz-sim is expected, such as 8 or 7.2".into());
    };
    if asked < first {
        let [major, minor] = first;
        let why = match target {
            Target::Gazebo => "its Hydrodynamics system reads neither xUabsU nor couplings",
            Target::GazeboAddedMass => "fluid_added_mass of the link has not been tested there",
            _ => "its Thruster system has not been tested there",
        };
        return refused(format!("`{}` needs gz-sim {major}.{minor} or later: {why}", target.name()));
    }
    let deprecated = target == Target::Gazebo && asked >= [9, 0];
    let text = "gz-sim 9 calls added mass in the Hydrodynamics system deprecated: use the target \
                `gazebo-added-mass`, in which it is part of the inertia of the link";
    Ok(if deprecated { vec![Finding::new(&codes::DEPRECATED, text)] } else { Vec::new() })
}

/// Major and minor version; `8` alone is the latest minor version of 8.
fn parsed(version: &str) -> Option<[u32; 2]> {
    let mut parts = version.split('.');
    let major = parts.next()?.parse().ok()?;
    let minor = parts.next().map_or(Some(u32::MAX), |m| m.parse().ok())?;
    parts.all(|p| p.parse::<u32>().is_ok()).then_some([major, minor])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(target: Target, version: &str) -> Result<usize, String> {
        let options = ExportOptions { version: Some(version.into()), ..ExportOptions::default() };
        check(target, &options).map(|f| f.len()).map_err(|e| e.to_string())
    }

    #[test]
    fn a_version_that_would_not_read_the_file_is_refused_with_the_reason() {
        assert!(with(Target::Gazebo, "7.1.0").unwrap_err().contains("7.2"));
        assert_eq!(
            (with(Target::Gazebo, "7.2"), with(Target::Gazebo, "7"), with(Target::Gazebo, "8.14")),
            (Ok(0), Ok(0), Ok(0))
        );
        assert_eq!((with(Target::Gazebo, "9"), with(Target::GazeboAddedMass, "9")), (Ok(1), Ok(0)));
        assert!(with(Target::GazeboAddedMass, "7.9").is_err());
        assert!(with(Target::Gazebo, "harmonic").unwrap_err().contains("such as 8"));
        assert!(with(Target::Csv, "1").unwrap_err().contains("omit"));
    }
}
