//! `discover --adopt`: the effects that were named, written into a campaign.

use std::path::Path;

use super::failure::Failure;
use super::output::Output;
use crate::campaign::{adopt as adopted, file::CampaignFile};
use crate::whole;

/// Writes `names` into the campaign itself, or into `to`, which begins as its copy.
pub(super) fn adopt(campaign: &Path, to: Option<&Path>, names: &[String], output: &Output) -> Result<(), Failure> {
    let own = CampaignFile::at(campaign);
    let to = to.map_or_else(|| own.clone(), Path::to_path_buf);
    let folder = |path: &Path| {
        let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        parent.canonicalize().map_err(|source| Failure::Read { file: parent.to_path_buf(), source })
    };
    if folder(&to)? != folder(&own)? {
        let text = format!(
            "{} lies in another folder, and logs are found from there: choose a name beside {}",
            to.display(),
            own.display()
        );
        return Err(Failure::Argument(text));
    }
    let from = if to.is_file() { &to } else { &own };
    let text = std::fs::read_to_string(from).map_err(|source| Failure::Read { file: from.clone(), source })?;
    let text = adopted(&text, names).map_err(|what| Failure::Argument(format!("{}: {what}", from.display())))?;
    // that it is edited was asked for: it is the one input that a call writes
    whole::write(&to, |file| std::io::Write::write_all(file, text.as_bytes()))
        .map_err(|source| Failure::Write { file: to.clone(), source })?;
    output.print(&format!(
        "{} has {} in its model now; next: hydrosysid fit {}",
        to.display(),
        names.join(", "),
        to.display()
    ));
    Ok(())
}
