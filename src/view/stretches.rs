//! Stretches of a log and their roles: training or validation.

use super::answer::Refusal;
use super::edit::runs::{self, Stretch};
use super::workspace::Workspace;

/// Refuses a stretch that ends before it begins.
fn checked(stretch: Stretch) -> Result<Stretch, Refusal> {
    let Stretch { from, to, .. } = stretch;
    if from.zip(to).is_some_and(|(from, to)| from >= to) {
        return Err(Refusal::bad("a stretch must end after it begins"));
    }
    Ok(stretch)
}

/// Sets the stretch and role of run `index`.
pub(super) fn set(workspace: &Workspace, index: usize, stretch: Stretch) -> Result<(), Refusal> {
    let stretch = checked(stretch)?;
    workspace.edit(|text| runs::set(text, index, stretch))
}

/// Adds a further stretch of the log of run `index`.
pub(super) fn add(workspace: &Workspace, index: usize, stretch: Stretch) -> Result<(), Refusal> {
    let stretch = checked(stretch)?;
    workspace.edit(|text| runs::add(text, index, stretch))
}

/// Removes run `index` from the campaign; its log stays where it is.
pub(super) fn remove(workspace: &Workspace, index: usize) -> Result<(), Refusal> {
    workspace.edit(|text| runs::remove(text, index))
}
