//! The `[discover]` table: options of the search for missing effects.

use serde::{Deserialize, Serialize};

use crate::discover::SearchOptions;
use crate::effects::Family;

/// Options of the discovery.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DiscoverTable {
    /// Accepted probability of a false discovery, over all candidates together. 0.01, as in the
    /// search: a false name is worse than none.
    pub level: f64,
    /// Maximum number of effects added. 5, as in the search: a longer chain of names explains nothing.
    pub max_effects: usize,
    /// Families that are searched; all by default.
    pub families: Vec<Family>,
    /// Seed of the random draws; that of the campaign if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
}

impl Default for DiscoverTable {
    fn default() -> DiscoverTable {
        let SearchOptions { level, most, families, .. } = SearchOptions::default();
        DiscoverTable { level, max_effects: most, families, seed: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn families_read_by_name() {
        let table: DiscoverTable = toml::from_str("families = ['body', 'sensor']\nlevel = 0.05").unwrap();
        assert_eq!(table.families, [Family::Body, Family::Sensor]);
        assert_eq!(table.max_effects, DiscoverTable::default().max_effects);
        assert_eq!(toml::from_str::<DiscoverTable>(&toml::to_string(&table).unwrap()).unwrap(), table);
    }
}
