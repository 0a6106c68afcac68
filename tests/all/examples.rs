//! The programs of `examples/`.

use crate::own_effect_example::found_and_fitted;

/// An effect of one's own is named where it is missing, and estimated: 6 N s⁴/m⁴ to three deviations and a hundredth, the speed
/// being read to a millimetre a second and the truth made by steps of a millisecond.
#[test]
fn an_effect_of_ones_own_is_named_and_estimated() {
    let (found, fit) = found_and_fitted().unwrap();
    let names: Vec<&str> = found.effects.iter().map(|e| e.id.as_str()).collect();
    assert_eq!(names, ["wave_drag@surge"], "{}", found.sentence);
    let k = fit.model.parameter("wave_drag@surge", "d_wave").unwrap();
    let (value, std) = (fit.model.parameters[k].value, fit.model.parameters[k].std.unwrap());
    assert!((value - 6.0).abs() < 3.0 * std + 0.06, "{value} ± {std}");
}
