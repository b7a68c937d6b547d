//! The 58 test vectors TV01-TV58 of the physics reference: those that no other test holds, and where the others are.

use asperity::math::{Estimate, direction, half_vector};
use asperity::meter::standards;
use asperity::model::parse;
use asperity::optics::fresnel;
use asperity::sample::AliasTable;
use glam::DVec3;
use std::path::Path;

fn at(theta_deg: f64, phi_deg: f64) -> DVec3 {
    direction(theta_deg.to_radians(), phi_deg.to_radians())
}

/// Vector, file and test. A test that is renamed or removed takes its vectors with it, and this list says so.
const HELD: [(&str, &str, &str); 58] = [
    ("TV01", "src/optics/fresnel.rs", "dielectric_vectors"),
    ("TV02", "src/optics/fresnel.rs", "polarised_vectors"),
    ("TV03", "src/optics/fresnel.rs", "polarised_vectors"),
    ("TV04", "src/optics/fresnel.rs", "polarised_vectors"),
    ("TV05", "src/optics/fresnel.rs", "polarised_vectors"),
    ("TV06", "src/optics/fresnel.rs", "conductor_vectors"),
    ("TV07", "src/optics/fresnel.rs", "mean_reflectance"),
    ("TV08", "src/optics/fresnel.rs", "polarised_vectors"),
    ("TV09", "tests/meter.rs", "flat_glass_is_exact_to_the_finite_source"),
    ("TV10", "tests/test_vectors.rs", "gloss_of_flat_glass_and_of_paper"),
    ("TV11", "tests/meter.rs", "mirror_reads_the_finite_source_correction"),
    ("TV12", "tests/test_vectors.rs", "gloss_of_flat_glass_and_of_paper"),
    ("TV13", "tests/meter.rs", "white_lambert"),
    ("TV14", "src/meter/stop.rs", "TV14"),
    ("TV15", "src/meter/stop.rs", "TV15"),
    ("TV16", "tests/meter.rs", "rough_black_glass_core_values"),
    ("TV17", "tests/meter.rs", "rough_black_glass_core_values"),
    ("TV18", "tests/meter.rs", "rough_black_glass_core_values"),
    ("TV19", "tests/meter.rs", "ward_has_a_ceiling"),
    ("TV20", "tests/models.rs", "normal_densities_and_lambda"),
    ("TV21", "tests/models.rs", "normal_densities_and_lambda"),
    ("TV22", "tests/models.rs", "normal_densities_and_lambda"),
    ("TV23", "tests/models.rs", "normal_densities_and_lambda"),
    ("TV24", "tests/models.rs", "brdf_values"),
    ("TV25", "tests/models.rs", "brdf_values"),
    ("TV26", "tests/models.rs", "brdf_values"),
    ("TV27", "tests/models.rs", "directional_albedos"),
    ("TV28", "tests/models.rs", "directional_albedos"),
    ("TV29", "tests/models.rs", "ward_forms_and_weights"),
    ("TV30", "tests/models.rs", "ward_forms_and_weights"),
    ("TV31", "tests/models.rs", "cook_torrance_reflects_what_it_receives"),
    ("TV32", "tests/models.rs", "he_torrance_factors"),
    ("TV33", "tests/test_vectors.rs", "total_integrated_scatter"),
    ("TV34", "tests/test_vectors.rs", "alias_tables_keep_their_weights"),
    ("TV35", "tests/test_vectors.rs", "alias_tables_keep_their_weights"),
    ("TV36", "tests/detectors/partitions.rs", "klems_patches_are_the_published_ones"),
    ("TV37", "src/model/beard_maxwell.rs", "shadowing_vector"),
    ("TV38", "src/model/facet_normals.rs", "normalised_bias"),
    ("TV39", "src/model/nef_bm.rs", "grazing_energy_unbounded_and_bounded"),
    ("TV40", "src/model/beard_maxwell.rs", "volume_albedo_vectors"),
    ("TV41", "tests/models.rs", "oren_nayar_looks_back_at_the_light"),
    ("TV42", "tests/test_vectors.rs", "half_and_difference_angles"),
    ("TV43", "tests/facet_sum.rs", "sawtooth"),
    ("TV44", "tests/detectors/closed_forms.rs", "lit_area_is_the_area_of_the_mean_plane"),
    ("TV45", "tests/facet_sum.rs", "projected_areas_sum_to_one_plus_lambda"),
    ("TV46", "src/facets/distribution.rs", "TV46"),
    ("TV47", "tests/kirchhoff.rs", "a_flat_map_is_a_rectangular_mirror"),
    ("TV48", "tests/models.rs", "he_torrance_factors"),
    ("TV49", "tests/models.rs", "he_torrance_factors"),
    ("TV50", "src/optics/material.rs", "names_and_indices"),
    ("TV51", "tests/test_vectors.rs", "scales_of_appearance"),
    ("TV52", "tests/test_vectors.rs", "scales_of_appearance"),
    ("TV53", "src/model/metallic.rs", "TV53"),
    ("TV54", "tests/test_vectors.rs", "visible_normals_of_ggx"),
    ("TV55", "tests/detectors/closed_forms.rs", "a_flat_mirror_fills_one_detector"),
    ("TV56", "tests/detectors/bounces.rs", "bounces_of_gaussian_surfaces"),
    ("TV57", "tests/models.rs", "directional_albedos"),
    ("TV58", "tests/models.rs", "minnaert_and_dust_in_closed_form"),
];

#[test]
fn every_vector_has_its_test() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (k, (id, file, test)) in HELD.iter().enumerate() {
        assert_eq!(*id, format!("TV{:02}", k + 1));
        let text = std::fs::read_to_string(root.join(file)).unwrap_or_else(|e| panic!("{id}: {file}: {e}"));
        assert!(text.contains(&format!("fn {test}()")) || test == id && text.contains(id), "{id}: no {test} in {file}");
    }
}

/// TV10, TV12: with a source of 2e-5 rad the reading is the ratio of Fresnel reflectances.
#[test]
fn gloss_of_flat_glass_and_of_paper() {
    let read = |name: &str, text: &str| {
        let mut meter = standards::by_name(name).unwrap();
        meter.source = asperity::meter::Shape::Rectangle([2e-5; 2]);
        meter.measure(&*parse(text, 587.6e-9).unwrap(), &Default::default()).unwrap()[0].estimate.value
    };
    for (name, gloss) in [("gloss-20", 89.182), ("gloss-60", 93.573), ("gloss-85", 99.430)] {
        let got = read(name, "dielectric:n=1.527");
        assert!((got - gloss).abs() < 1e-3, "{name}: {got}");
    }
    let got = read("gloss-75", "mirror");
    assert!((got - 384.3518).abs() < 1e-3, "{got}");
    assert!((got - 100.0 / fresnel::dielectric(75f64.to_radians().cos(), 1.540)).abs() < 1e-3);
}

/// TV33: what leaves the specular core of a polished surface, `1 - exp(-(4 pi sigma / lambda)^2)`.
#[test]
fn total_integrated_scatter() {
    let brdf = parse("he-torrance:sigma=3nm,tau=20um,n=1.5", 632.8e-9).unwrap();
    let scattered = 1.0 - brdf.specular_core(DVec3::Z) / 0.04;
    assert!((scattered - 0.00354289945512).abs() < 1e-12, "{scattered}");
}

/// TV34, TV35: weights are drawn as they are; one that is zero is never drawn.
#[test]
fn alias_tables_keep_their_weights() {
    for weights in [&[0.1, 0.2, 0.3, 0.4][..], &[0.0, 1.0, 3.0]] {
        let total: f64 = weights.iter().sum();
        let found = AliasTable::new(weights).unwrap().probabilities();
        for (p, w) in found.iter().zip(weights) {
            // Thresholds have 32 bits.
            assert!((p - w / total).abs() < 1e-9, "{found:?}");
            assert!(*w > 0.0 || *p == 0.0);
        }
    }
}

/// TV42: half and difference angles (Rusinkiewicz 1998) of the library's half vector, which all of `f_r` stands on.
#[test]
fn half_and_difference_angles() {
    let (i, o) = (at(60.0, 0.0), at(70.0, 150.0));
    let h = half_vector(i, o);
    let (theta_h, phi_h) = (asperity::math::frame::theta(h), asperity::math::frame::phi(h));
    assert!((theta_h.to_degrees() - 29.311410748).abs() < 1e-6 && (phi_h.to_degrees() - 83.6570886934).abs() < 1e-6);
    // The source turned by -phi_h about z and by -theta_h about y.
    let turned = glam::DQuat::from_rotation_y(-theta_h) * glam::DQuat::from_rotation_z(-phi_h) * i;
    assert!((turned.z.acos().to_degrees() - 61.1299078126).abs() < 1e-6);
    assert!((turned.y.atan2(turned.x).to_degrees() + 100.617362418).abs() < 1e-6, "{turned}");
}

/// TV51, TV52.
#[test]
fn scales_of_appearance() {
    use asperity::meter::appearance::{flop_index, log_haze};
    for (haze, units) in [(20.0, 386.8235), (100.0, 999.9244)] {
        assert!((log_haze(Estimate::exact(haze)).value - units).abs() < 1e-3);
    }
    assert!((flop_index(120.0, 60.0, 30.0).unwrap() - 11.74225).abs() < 1e-4);
}

/// TV54: density of a visible normal, and of the direction it reflects to.
#[test]
fn visible_normals_of_ggx() {
    let (brdf, wi) = (parse("ggx:alpha=0.3,material=mirror", 550e-9).unwrap(), at(60.0, 0.0));
    let m = DVec3::new(0.01595242, 0.11281222, 0.99348826).normalize();
    let density = brdf.pdf(wi, asperity::math::reflect(wi, m));
    assert!((density / 1.2993682 - 1.0).abs() < 1e-6, "{density}");
    assert!((4.0 * wi.dot(m) * density / 2.6536183 - 1.0).abs() < 1e-6);
}
