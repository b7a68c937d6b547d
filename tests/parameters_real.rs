//! Sq, Sdq, grid, pitch and gaps of maps that instruments wrote, against the table that accompanies them.

use asperity::heightmap::read::{ReadOptions, read};
use asperity::heightmap::{Edges, Survey, level::level};
use std::path::PathBuf;

/// Found by an independent reader (NumPy): file, Sq after the plane \[nm\], Sdq and slopes of the 1-pixel differences,
/// missing share.
const TABLE: &[(&str, f64, [f64; 2], f64)] = &[
    ("real/al3d-1.al3d", 289.8221, [0.0649118, 0.0618888], 0.0),
    ("real/x3p-2.x3p", 77.19303, [0.0556106, 0.0275797], 0.0),
    ("real/opd-1.opd", 6.711198, [0.0127326, 0.0128074], 0.00038),
    ("real/plu-1.plu", 18.28196, [0.003948149, 0.002411433], 0.0),
    ("real/nms-1.nms", 33.51491, [0.01771587, 0.01846676], 0.0),
    ("real/sur-2.sur", 17.10414, [0.002285561, 0.002225793], 0.00043),
    ("real/bcrf-1.bcrf", 24.36725, [0.01170957, 0.01612036], 0.0),
    ("converted/di-1.x3p", 9.843662, [0.211040, 0.736782], 0.0),
    ("real/valid_zygo_dat_file.dat", 44.59141, [6.256763e-5, 6.386985e-5], 0.257),
    ("real/sample-land.x3p", 33640.28, [0.699822, 0.557098], 0.108),
];

fn shared(name: &str) -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/heightmaps");
    let folder = std::env::var_os("ASPERITY_SHARED").map_or_else(|| PathBuf::from(default), PathBuf::from);
    let path = folder.join(name);
    if !path.exists() {
        eprintln!("SKIPPED: {} is absent; set ASPERITY_SHARED to the folder of real height maps", path.display());
        return None;
    }
    Some(path)
}

#[test]
fn the_table_of_the_real_maps_is_reproduced() {
    for &(name, sq_nm, slopes, missing) in TABLE {
        let Some(path) = shared(name) else { continue };
        let map = level(&read(&path, &ReadOptions::default()).unwrap(), Edges::Open).unwrap();
        let s = Survey::of(&map);
        let off = |found: f64, known: f64| 100.0 * (found / known - 1.0);
        let sdq = slopes[0].hypot(slopes[1]);
        eprintln!(
            "{name}: Sq {:+.4} %, Sdq {:+.4} %, missing {:.5}; {:?}",
            off(s.heights.sq * 1e9, sq_nm),
            off(s.gradient.sdq, sdq),
            s.missing_fraction,
            s.texture
        );
        for w in &s.warnings {
            eprintln!("    {w}");
        }
        assert!(off(s.heights.sq * 1e9, sq_nm).abs() < 0.1);
        assert!(off(s.gradient.sdq, sdq).abs() < 0.1);
        // The slopes at the pitch are the same numbers found another way.
        for (scales, rms) in [&s.sampling.along_x, &s.sampling.along_y].into_iter().zip(s.gradient.rms) {
            assert!((scales[0].rms / rms - 1.0).abs() < 1e-12);
        }
        assert!((s.missing_fraction - missing).abs() < 5e-4);
    }
}
