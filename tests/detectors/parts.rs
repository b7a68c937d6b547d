//! Counting is exact: any number of threads and any number of parts give the same numbers.

use super::gaussian;
use asperity::heightmap::{Edges, HeightMap};
use asperity::report::detectors_csv;
use asperity::scatter::run::{Run, Sums, fingerprint};
use asperity::scatter::{Counting, Footprint, Method, Options, Part, Partition, Wave, count};

fn map(edges: Edges) -> HeightMap {
    HeightMap { edges, pitch_y: 1.4, ..gaussian(120, 6.0, 0.35, 3) }
}

fn options(method: Method) -> Options {
    let degrees = |list: &[f64]| list.iter().map(|t| t.to_radians()).collect();
    Options {
        method,
        theta_i: degrees(&[0.0, 50.0, 80.0]),
        phi_i: degrees(&[10.0, 200.0]),
        rays: 60_000,
        ..Options::default()
    }
}

/// The rows of a run, on so many threads.
fn rows(map: &HeightMap, options: &Options, counting: &Counting, run: &mut Run, threads: usize) -> String {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| detectors_csv(&count(map, options, counting, run, &|_| ()).unwrap()))
}

#[test]
fn threads_and_parts_do_not_show() {
    let dir = tempfile::tempdir().unwrap();
    let footprint = Some(Footprint { columns: [20, 100], rows: [7, 119] });
    for (edges, method, partition, averaged, footprint) in [
        (Edges::Open, Method::Facets, Partition::Klems, false, footprint),
        (Edges::Periodic, Method::Facets, Partition::HalfVector, true, None),
        (Edges::Mirrored, Method::Rays, Partition::ShirleyChiu { k: 3 }, false, footprint),
        (Edges::Open, Method::Rays, Partition::HalfVector, true, None),
        // At unit pitch waves of unit length: rays at 0 and 50 deg, waves at 80.
        (Edges::Open, Method::Auto, Partition::EqualArea { count: 200 }, false, footprint),
    ] {
        let (map, options) = (map(edges), Options { footprint, ..options(method) });
        let options = Options { wave: Wave { wavelength: 5.0, ..Wave::default() }, ..options };
        let counting = Counting { partition, averaged };
        let one = rows(&map, &options, &counting, &mut Run::Whole, 1);
        assert!(one.lines().count() > 100 && !one.contains("NaN") && !one.contains("inf"));
        for threads in [2, 3] {
            assert!(
                rows(&map, &options, &counting, &mut Run::Whole, threads) == one,
                "{threads} threads, {counting:?}"
            );
        }
        let mut files = Vec::new();
        for k in 1..=4 {
            let word = fingerprint(&map, &options, &format!("{counting:?}"));
            let mut run = Run::Part(Sums::new(Part::new(k, 4).unwrap(), word));
            rows(&map, &options, &counting, &mut run, 1 + k as usize % 2);
            let Run::Part(sums) = run else { panic!() };
            files.push(dir.path().join(format!("{k}")));
            sums.save(&files[k as usize - 1]).unwrap();
        }
        files.rotate_left(1);
        let mut run = Run::Merged { sums: Sums::merge(&files).unwrap(), next: 0 };
        assert!(rows(&map, &options, &counting, &mut run, 2) == one, "merged, {counting:?}");
    }
}

/// A footprint lights facets, it does not cut the map: rays and facets agree on it, and differ from a cropped map.
#[test]
fn the_rest_of_the_map_still_shadows() {
    for edges in [Edges::Open, Edges::Mirrored, Edges::Periodic] {
        let map = map(edges);
        let footprint = Footprint { columns: [50, 90], rows: [60, 100] };
        let counting = Counting { partition: Partition::EqualArea { count: 12 }, averaged: false };
        let footprint = Some(footprint);
        let run = |method| {
            let options = Options {
                theta_i: vec![75f64.to_radians()],
                phi_i: vec![0.4],
                rays: 400_000,
                footprint,
                ..options(method)
            };
            count(&map, &options, &counting, &mut Run::Whole, &|_| ()).unwrap().directions.remove(0)
        };
        let (facets, rays) = (run(Method::Facets), run(Method::Rays));
        assert!(facets.tally.shadowed > 0.1, "{}", facets.tally.shadowed);
        for k in 0..12 {
            let ray_error = rays.tally.fraction(k).standard_error;
            // Facets stand for their centroids: 3200 of them hold a share to some 0.003.
            let tolerance = 4.0 * ray_error + 0.006;
            let (a, b) = (facets.share[k].value, rays.share[k].value);
            assert!((a - b).abs() < tolerance, "{edges:?} detector {k}: {a} {b} +- {ray_error}");
        }
    }
}
