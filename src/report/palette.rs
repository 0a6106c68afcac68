//! Colours of all figures, for light and for dark mode, for the page and for a figure on its own.
//!
//! The six tones t1 to t6 differ in lightness as well as in hue and are distinct for the common
//! kinds of colour blindness (after M. Okabe and K. Ito, *Color Universal Design*, 2008, darkened
//! for contrast on white); lines and marks also differ in dash and shape, and checks have a sign.

/// (name, light, dark)
const COLOURS: &[(&str, &str, &str)] = &[
    ("paper", "#ffffff", "#15191d"),
    ("raised", "#f5f7f8", "#1d2328"),
    ("ink", "#182027", "#e4e9ed"),
    ("muted", "#56626d", "#9eabb6"),
    ("rule", "#dde2e6", "#313a42"),
    ("grid", "#e7ebee", "#262d34"),
    ("axis", "#a9b3bc", "#56626d"),
    ("t0", "#77838e", "#8d99a4"),
    ("t1", "#0a67ad", "#62b5f5"),
    ("t2", "#c4480f", "#f59a66"),
    ("t3", "#0b7f60", "#55cba5"),
    ("t4", "#8c4488", "#d79ad3"),
    ("t5", "#8f6a00", "#e3bd4a"),
    ("t6", "#3f4b57", "#b4c0cb"),
    ("heat-high", "#6ea9dc", "#27639a"),
    ("heat-low", "#eda27c", "#9f4b26"),
    ("green", "#12724a", "#5fce96"),
    ("amber", "#8a5b00", "#e6b84c"),
    ("red", "#b0231c", "#ff8f85"),
    ("link", "#0a67ad", "#62b5f5"),
];

const CHART: &str = include_str!("../../templates/chart.css");

/// Style sheet of all figures on a page: variables for light and dark (paper is always light), then
/// the classes.
pub fn page_style() -> String {
    let list = |pick: fn(&(&str, &str, &str)) -> String| COLOURS.iter().map(pick).collect::<String>();
    let light = list(|(name, light, _)| format!("--{name}:{light};"));
    let dark = list(|(name, _, dark)| format!("--{name}:{dark};"));
    format!(
        ":root{{color-scheme:light dark;{light}}}\n@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}\n{CHART}"
    )
}

/// The classes with the light colours as values, for a figure on its own.
pub fn standalone_style() -> String {
    COLOURS.iter().fold(CHART.to_string(), |css, (name, light, _)| css.replace(&format!("var(--{name})"), light))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance of `#rrggbb`, WCAG 2.2.
    fn luminance(colour: &str) -> f64 {
        let channel = |k: usize| {
            let c = f64::from(u8::from_str_radix(&colour[k..k + 2], 16).unwrap()) / 255.0;
            if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
    }

    fn contrast(a: &str, b: &str) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    fn colour(name: &str) -> [&'static str; 2] {
        let (_, light, dark) = COLOURS.iter().find(|(n, ..)| *n == name).unwrap();
        [light, dark]
    }

    /// WCAG 2.2 asks for 4.5 for text and 3 for the parts of a figure.
    #[test]
    fn text_and_tones_stand_out_from_the_paper_in_both_modes() {
        for mode in 0..2 {
            let paper = colour("paper")[mode];
            for text in ["ink", "muted", "green", "amber", "red", "link", "t1", "t2", "t3", "t4", "t5", "t6"] {
                let ratio = contrast(colour(text)[mode], paper);
                assert!(ratio >= 4.5, "{text}: {ratio:.2}");
            }
            assert!(contrast(colour("t0")[mode], paper) >= 3.0);
            for cell in ["heat-high", "heat-low"] {
                let ratio = contrast(colour("ink")[mode], colour(cell)[mode]);
                assert!(ratio >= 4.5, "digits on {cell}: {ratio:.2}");
            }
        }
    }

    #[test]
    fn a_figure_on_its_own_needs_no_variables() {
        assert!(!standalone_style().contains("var("));
    }
}
