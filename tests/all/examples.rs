//! The programs of `examples/`.

use crate::own_effect_example::found_and_fitted;

/// A user-defined effect is found if it is missing, and estimated as 6 N s⁴/m⁴ within three
/// standard deviations plus 1 %. The 1 % is for the speed, which is rounded to 1 mm/s, and for the
/// steps of 1 ms by which the log is simulated.
#[test]
fn an_effect_of_ones_own_is_named_and_estimated() {
    let (found, fit) = found_and_fitted().unwrap();
    let names: Vec<&str> = found.effects.iter().map(|e| e.id.as_str()).collect();
    assert_eq!(names, ["wave_drag@surge"], "{}", found.sentence);
    let k = fit.model.parameter("wave_drag@surge", "d_wave").unwrap();
    let (value, std) = (fit.model.parameters[k].value, fit.model.parameters[k].std.unwrap());
    assert!((value - 6.0).abs() < 3.0 * std + 0.06, "{value} ± {std}");
}
