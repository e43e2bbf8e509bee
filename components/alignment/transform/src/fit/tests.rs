//! The vectors of the reference, random fits, refusals.

use super::*;

fn marks(rows: &[(f64, f64, f64, f64)]) -> Vec<Mark> {
    let mark = |r: &(f64, f64, f64, f64)| Mark {
        file: Vector::new(r.0, r.1),
        machine: Vector::new(r.2, r.3),
    };
    rows.iter().map(mark).collect()
}

fn with(model: Model) -> Conditions {
    Conditions { model, ..Conditions::default() }
}

/// Compares with the digits that a vector states.
fn near(got: f64, wanted: f64, within: f64) {
    assert!((got - wanted).abs() <= within, "{got}, must be {wanted} within {within}");
}

const E: &[(f64, f64, f64, f64)] = &[
    (10.0, 10.0, 110.0021, 62.9333),
    (190.0, 10.0, 322.7206, 100.4413),
    (10.0, 110.0, 91.8462, 171.4289),
];
const F: &[(f64, f64, f64, f64)] = &[
    (10.0, 10.0, 110.014, 62.925),
    (190.0, 10.0, 322.711, 100.456),
    (190.0, 110.0, 304.571, 208.948),
    (10.0, 110.0, 91.832, 171.42),
];

#[test]
fn a_no_change() {
    let same = marks(&[(0.0, 0.0, 0.0, 0.0), (100.0, 0.0, 100.0, 0.0), (0.0, 50.0, 0.0, 50.0)]);
    for (_, model) in Model::NAMES {
        let fit = fit(&same, &with(model)).unwrap();
        let parts = fit.transform.parts();
        near(parts.turn, 0.0, 1e-12);
        near(parts.scale_x, 1.0, 1e-12);
        near(parts.scale_y, 1.0, 1e-12);
        near(parts.shear, 0.0, 1e-12);
        near(parts.shift.length(), 0.0, 1e-12);
        assert!(fit.rms < 1e-12 && fit.transform.warnings().is_empty());
    }
}

#[test]
fn b_one_mark_is_a_shift() {
    let fit = fit(&marks(&[(0.0, 0.0, 2.0, 1.0)]), &Conditions::default()).unwrap();
    assert_eq!(fit.transform, Transform { linear: Matrix::IDENTITY, shift: Vector::new(2.0, 1.0) });
    assert_eq!(fit.model, Model::Shift);
}

#[test]
fn c_two_marks_are_a_similarity() {
    let two = marks(&[(0.0, 0.0, 2.0, 1.0), (7.0, 8.0, 7.5, 10.09)]);
    let found = fit(&two, &Conditions::default()).unwrap();
    near(found.transform.parts().turn, 10.00945, 5e-6);
    near(found.transform.parts().scale_x, 0.999460, 5e-7);
    let rigid = fit(&two, &with(Model::Rigid)).unwrap().transform.parts();
    near(rigid.turn, 10.00945, 5e-6);
    near(rigid.scale_x, 1.0, 1e-12);
}

#[test]
fn d_two_scales() {
    let three = marks(&[(0.0, 0.0, 0.0, 0.0), (10.0, 0.0, 12.0, 0.0), (0.0, 10.0, 0.0, 11.0)]);
    for model in [Model::Affine, Model::ScaleXy, Model::Auto] {
        let transform = fit(&three, &with(model)).unwrap().transform;
        near(transform.parts().scale_x, 1.2, 1e-12);
        near(transform.parts().scale_y, 1.1, 1e-12);
        assert_eq!(transform.warnings().len(), 2);
    }
}

#[test]
fn e_three_marks_are_an_affine_map() {
    let transform = fit(&marks(E), &Conditions::default()).unwrap().transform;
    let parts = transform.parts();
    near(parts.turn, 10.0, 1e-4);
    near(parts.scale_x, 1.2, 1e-6);
    near(parts.scale_y, 1.1, 1e-6);
    near(parts.shear, 0.5, 1e-4);
    near(parts.shift.x, 100.0, 1e-4);
    near(parts.shift.y, 50.0, 1e-4);
    let m = transform.linear;
    for (got, wanted) in
        [(m.m11, 1.181769), (m.m12, -0.181559), (m.m21, 0.208378), (m.m22, 1.084956)]
    {
        near(got, wanted, 1e-6);
    }
    let point = transform.apply(Vector::new(100.0, 60.0));
    near(point.x, 207.2834, 1e-4);
    near(point.y, 135.9351, 1e-4);
}

#[test]
fn f_four_marks_with_errors() {
    let found = fit(&marks(F), &Conditions::default()).unwrap();
    let m = found.transform.linear;
    for (got, wanted) in
        [(m.m11, 1.181767), (m.m12, -0.181610), (m.m21, 0.208497), (m.m22, 1.084935)]
    {
        near(got, wanted, 6e-7);
    }
    let parts = found.transform.parts();
    near(parts.shift.x, 100.0019, 5e-5);
    near(parts.shift.y, 49.9914, 5e-5);
    near(parts.turn, 10.0056, 5e-5);
    near(parts.shear, 0.5029, 5e-5);
    near(found.rms, 0.0105, 5e-5);
    for (n, residual) in found.residuals.iter().enumerate() {
        let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
        near(residual.x * sign, 0.0105, 5e-5);
        near(residual.y * sign, -0.0007, 6e-5);
    }
    let refused = fit(&marks(F), &with(Model::Similarity)).unwrap_err();
    let Misfit::Residual(rms, 0.1, ..) = refused else { panic!("{refused}") };
    near(rms, 4.39, 0.005);
}

#[test]
fn g_a_similarity_with_errors() {
    let three =
        marks(&[(0.0, 0.0, 5.01, 2.99), (100.0, 0.0, 103.48, 20.37), (0.0, 100.0, -12.36, 101.47)]);
    let found = fit(&three, &with(Model::Similarity)).unwrap();
    let parts = found.transform.parts();
    near(parts.turn, 10.00516, 5e-6);
    near(parts.scale_x, 0.99993, 5e-6);
    near(parts.shift.x, 5.01, 1e-9);
    near(parts.shift.y, 2.995, 1e-9);
    near(found.rms, 0.0041, 5e-5);
}

#[test]
fn h_the_inverse_leads_back() {
    let transform = fit(&marks(E), &Conditions::default()).unwrap().transform;
    let back = transform.inverse().unwrap();
    for n in 0..1000 {
        let p = Vector::new(f64::from(n) * 0.37 - 100.0, f64::from(n % 37) * 11.0 - 200.0);
        let there = back.apply(transform.apply(p));
        near((there - p).length(), 0.0, 1e-9);
    }
}

#[test]
fn parts_and_transform_agree_for_mirrored_parts_too() {
    for turn in [-179.0, -45.0, 0.0, 10.0, 90.0] {
        for scale_y in [-1.1, 0.9] {
            for shear in [-3.0, 0.0, 0.5] {
                let shift = Vector::new(3.0, -4.0);
                let parts = Parts { turn, scale_x: 1.2, scale_y, shear, shift };
                let again = Transform::from_parts(&parts).parts();
                near(again.turn, turn, 1e-10);
                near(again.scale_x, 1.2, 1e-12);
                near(again.scale_y, scale_y, 1e-12);
                near(again.shear, shear, 1e-10);
            }
        }
    }
}

#[test]
fn scale_xy_is_the_least_sum_of_squares() {
    let rows: Vec<Mark> = marks(F);
    let options = Conditions { model: Model::ScaleXy, tolerance: 10.0, mirror: false };
    let found = fit(&rows, &options).unwrap();
    let parts = found.transform.parts();
    near(parts.shear, 0.0, 1e-12);
    let cost = |parts: &Parts| -> f64 {
        let transform = Transform::from_parts(parts);
        let off = |m: &Mark| (m.machine - transform.apply(m.file)).length();
        rows.iter().map(|m| off(m) * off(m)).sum()
    };
    let least = cost(&parts);
    for by in [-1e-4, 1e-4] {
        assert!(cost(&Parts { turn: parts.turn + by, ..parts }) > least);
        assert!(cost(&Parts { scale_x: parts.scale_x + by, ..parts }) > least);
        assert!(cost(&Parts { scale_y: parts.scale_y + by, ..parts }) > least);
        let shift = parts.shift + Vector::new(by, 0.0);
        assert!(cost(&Parts { shift, ..parts }) > least);
    }
}

#[test]
fn mirrored_parts_are_fitted_on_request_alone() {
    let shift = Vector::new(300.0, 20.0);
    let parts = Parts { turn: 30.0, scale_x: 1.0, scale_y: -1.0, shear: 0.0, shift };
    let transform = Transform::from_parts(&parts);
    let places = [(10.0, 10.0), (190.0, 15.0), (20.0, 120.0)];
    let rows: Vec<Mark> = places
        .iter()
        .map(|p| Vector::new(p.0, p.1))
        .map(|file| Mark { file, machine: transform.apply(file) })
        .collect();
    for model in [Model::Affine, Model::Similarity, Model::Rigid, Model::ScaleXy] {
        let mirrored = Conditions { model, mirror: true, ..Conditions::default() };
        let found = fit(&rows, &mirrored).unwrap().transform.parts();
        near(found.turn, 30.0, 1e-9);
        near(found.scale_y, -1.0, 1e-12);
        assert!(fit(&rows, &with(model)).is_err(), "{model:?}");
    }
    assert_eq!(fit(&rows, &with(Model::Affine)), Err(Misfit::Mirrored));
    let mirror = Conditions { mirror: true, ..Conditions::default() };
    assert_eq!(fit(&marks(E), &mirror), Err(Misfit::NotMirrored));
}

#[test]
fn marks_that_determine_nothing_are_refused_by_name() {
    let say = |rows: &[(f64, f64, f64, f64)], model| {
        fit(&marks(rows), &with(model)).unwrap_err().to_string()
    };
    let line = &[(0.0, 0.0, 0.0, 0.0), (50.0, 1.0, 50.0, 1.0), (100.0, 0.0, 100.0, 0.0)];
    assert_eq!(
        say(line, Model::Affine),
        "the marks lie on a line in the file: take one beside it, or the model similarity"
    );
    assert!(fit(&marks(line), &with(Model::Similarity)).is_ok());
    assert_eq!(
        say(&[(0.0, 0.0, 0.0, 0.0), (3.0, 0.0, 3.0, 0.0)], Model::Auto),
        "marks 1 and 2 are 3.000 mm apart in the file: at least 5 mm are needed"
    );
    assert_eq!(
        say(&[(0.0, 0.0, 7.0, 0.0), (9.0, 0.0, 7.0, 1.0)], Model::Auto),
        "marks 1 and 2 are 1.000 mm apart as measured: at least 5 mm are needed"
    );
    assert_eq!(say(&[], Model::Auto), "0 marks: the model shift needs between 1 and 1000");
    assert_eq!(
        say(&line[..2], Model::Affine),
        "2 marks: the model affine needs between 3 and 1000"
    );
    assert_eq!(
        say(&[(0.0, 0.0, f64::NAN, 0.0)], Model::Auto),
        "mark 1: a coordinate is not a number below 1e9 mm"
    );
    let mut bad = F.to_vec();
    bad[2].2 += 2.0;
    let text = say(&bad, Model::Affine);
    assert!(text.contains("and 0.1 mm are allowed: mark "), "{text}");
    let nan = Conditions { tolerance: f64::NAN, ..Conditions::default() };
    assert!(matches!(fit(&marks(F), &nan), Err(Misfit::Residual(..))));
}
