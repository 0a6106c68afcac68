use super::*;

/// Value of the formula for u = 0.5, v = -0.25 and all other names 2.
fn value(text: &str) -> f64 {
    let graph = Graph::new();
    let formula = Formula::parse(text).unwrap();
    let read = |name: &str| match name {
        "u" => graph.constant(0.5),
        "v" => graph.constant(-0.25),
        _ => graph.constant(2.0),
    };
    formula.lower(&graph, &read).as_constant().unwrap()
}

#[test]
fn operators_bind_as_in_mathematics() {
    for (text, expected) in [
        ("1 + 2*3 - 4/2/2", 6.0),
        ("-u^2", -0.25),
        ("(-u)^2", 0.25),
        ("2^3^2", 512.0),
        ("2^-1*3", 1.5),
        ("2*-u", -1.0),
        ("10 - 3 - 2", 5.0),
        ("- - u", 0.5),
        ("+u**2", 0.25),
        (" u*abs( u )+1e-3 ", 0.251),
        (".5+1.", 1.5),
        ("max(u, min(w, 3))", 2.0),
        ("sqrt(w*8) + log(exp(1)) + atan(tan(0.3)) - 0.3", 5.0),
        ("cos(2*pi) + sign(v) + tanh(0)", 0.0),
        ("u > 0 && v < 0 || w == 7", 1.0),
        ("u >= 0.5 && v <= -0.25 && !(w != 2)", 1.0),
        ("u + 0.5 > 1", 0.0),
        ("!u + (3 && 0)", 0.0),
    ] {
        assert!((value(text) - expected).abs() < 1e-15, "{text} is {}", value(text));
    }
}

#[test]
fn mistakes_are_shown_at_their_column() {
    let refuse = |text: &str| Formula::parse(text).unwrap_err().to_string();
    for (text, column, found, expected) in [
        ("u * ", 5, "the formula ends", "a number, a name or `(`"),
        ("", 1, "the formula ends", "a number, a name or `(`"),
        ("u v", 3, "`v`", "an operator or the end"),
        ("u $ v", 3, "`$`", "an operator or the end"),
        ("(u + * v)", 6, "`*`", "a number, a name or `(`"),
        ("(u + v", 7, "the formula ends", "an operator or `)`"),
        ("sin(u", 6, "the formula ends", "an operator or `)`"),
        ("sin()", 5, "`)`", "a number, a name or `(`"),
        ("u + v)", 6, "`)`", "an operator or the end"),
        ("1 < u < 2", 7, "`<`", "an operator or the end"),
        ("2u", 2, "`u`", "an operator or the end"),
        ("ψ + §", 5, "`§`", "a number, a name or `(`"),
    ] {
        let message = refuse(text);
        assert_eq!(message, format!("`{text}`: {found} at column {column}, where {expected} would be right"));
    }
    assert!(refuse("u + sine(v)").ends_with("no function is called `sine` (column 5), did you mean `sin`?"));
    assert!(refuse("min(u)").ends_with("`min` at column 1 takes 2 argument(s), not 1"));
    assert!(refuse(&"(".repeat(1000)).contains("too large"));
    assert!(refuse(&"-".repeat(999)).contains("the formula ends"));
    let formula = Formula::parse("wind_sped * cos(psi)").unwrap();
    let wrong = formula.check(["psi", "wind_speed", "t"]).unwrap_err().to_string();
    assert!(wrong.ends_with("no channel is called `wind_sped` (column 1), did you mean `wind_speed`?"), "{wrong}");
    assert_eq!(formula.check(["psi", "wind_sped"]), Ok(()));
}

#[test]
fn a_run_is_evaluated_at_any_instant() {
    let time: std::sync::Arc<[f64]> = (0..20).map(f64::from).collect();
    let mut run = Run::default();
    run.signals.insert("u".into(), Signal::new(time, (0..20).map(|k| 2.0 * f64::from(k)).collect::<Vec<_>>()));
    let at: Vec<f64> = (0..37).map(|k| 0.5 * f64::from(k)).collect();
    let formula = Formula::parse("u - t").unwrap();
    assert_eq!(formula.over(&run, &at), Ok(at.clone()));
    assert_eq!(formula.over(&run, &[-1.0, 30.0]), Ok(vec![1.0, 8.0]));
    assert_eq!(formula.over(&run, &[]), Ok(vec![]));
    assert_eq!(Formula::parse("t > 1.2").unwrap().over(&run, &[1.0, 2.0]), Ok(vec![0.0, 1.0]));
    let absent = Formula::parse("u + v").unwrap().over(&run, &at);
    assert!(matches!(absent, Err(FormulaError::UnknownName { column: 5, .. })));
}

#[test]
fn names_are_listed_once_and_constants_are_no_names() {
    let formula = Formula::parse("tau_u*pi + u*u - psi").unwrap();
    assert_eq!(formula.names().into_iter().collect::<Vec<_>>(), ["psi", "tau_u", "u"]);
    assert_eq!(formula.text(), "tau_u*pi + u*u - psi");
}
