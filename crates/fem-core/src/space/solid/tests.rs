use super::*;

const CORNERS: [[f64; 3]; 4] = [[0.1, 0.2, -0.3], [1.3, 0.1, 0.2], [0.4, 0.9, 0.1], [0.2, 0.3, 1.1]];

#[test]
fn facets_enclose_the_volume() {
    let corners = CORNERS.map(Vector3::from);
    let volume = Solid::measure(&corners);
    assert_eq!(Solid::sure_measure(&corners), Some(volume));
    // ∮ n dA = 0 and ∮ x·n dA = 3 V, by centroids: both are linear on each facet.
    let (mut sum, mut thrice) = (Vector3::zeros(), 0.0);
    for k in 0..4 {
        let facet = Solid::facet(k).map(|c| corners[c]);
        let area = Solid::facet_normal(&facet) * Solid::facet_measure(&facet);
        sum += area;
        thrice += facet.iter().map(|p| p.dot(&area) / 3.0).sum::<f64>();
    }
    assert!(sum.length() < 1e-15 && (thrice - 3.0 * volume).abs() < 1e-15);
}

#[test]
fn gradients_are_those_of_the_barycentric_coordinates() {
    let corners = CORNERS.map(Vector3::from);
    let gradients = Solid::gradients(&corners, Solid::measure(&corners));
    for (i, gradient) in gradients.iter().enumerate() {
        for j in 1..4 {
            let expected = f64::from(u8::from(i == j)) - f64::from(u8::from(i == 0));
            assert!((gradient.dot(&(corners[j] - corners[0])) - expected).abs() < 1e-15);
        }
    }
}

#[test]
fn a_flat_tetrahedron_has_no_sure_volume() {
    let mut corners = CORNERS.map(Vector3::from);
    corners[3] = 0.2 * corners[0] + 0.3 * corners[1] + 0.5 * corners[2];
    assert_eq!(Solid::sure_measure(&corners), None);
}

#[test]
fn a_basis_is_completed() {
    let a = Vector3::new(0.6, 0.0, -0.8);
    let [b, c, zero] = Solid::complement(&[a]);
    assert_eq!(zero, Vector3::zeros());
    assert!((a.cross(&b) - c).length() < 1e-15 && b.dot(&a).abs() < 1e-16);
    assert!((Solid::complement(&[b, c])[0] - a).length() < 1e-15);
}

#[test]
fn a_spin_has_the_moment_it_is_computed_from() {
    let arms = CORNERS.map(|x| (x[0] + 1.0, Vector3::from(x)));
    let spin = Vector3::new(0.3, -0.7, 0.2);
    let moment = arms.iter().map(|(w, x)| *w * Solid::moment(*x, Solid::turned(spin, *x))).sum();
    assert!((Solid::spin_of(moment, arms.into_iter()) - spin).length() < 1e-14);
}
