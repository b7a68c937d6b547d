//! The pyramid march against an exhaustive test of every triangle, and against closed forms.

use asperity::facets::starts::{Start, Starts};
use asperity::facets::visibility::{Fate, HeightField, Hit, Ray};
use asperity::facets::{Packet, slopes};
use asperity::heightmap::{Edges, HeightMap, synth};
use asperity::math::{direction, frame, random::CounterRng};
use fearless_simd::Level;
use glam::DVec3;
use ndarray::{Array2, s};

fn rough(width: usize, height: usize, edges: Edges, gaps: bool) -> HeightMap {
    let mut rng = CounterRng::new(11, 0, 0);
    let heights = Array2::from_shape_fn((height, width), |_| {
        let h = rng.uniform() as f32 * 3.0;
        if gaps && rng.uniform() < 0.1 { f32::NAN } else { h }
    });
    HeightMap { heights, pitch_x: 1.0, pitch_y: 1.7, edges, removed_slopes: [0.0; 2] }
}

/// Nearest crossing from above over all triangles of an open map, in f64, by Moeller-Trumbore style algebra.
fn exhaustive(map: &HeightMap, origin: DVec3, d: DVec3) -> Option<f64> {
    let vertex = |r: usize, c: usize| {
        DVec3::new(c as f64 * map.pitch_x, -(r as f64) * map.pitch_y, f64::from(map.heights[[r, c]]))
    };
    let mut nearest: Option<f64> = None;
    for r in 0..map.height() - 1 {
        for c in 0..map.width() - 1 {
            let (a, b, e, f) = (vertex(r, c), vertex(r, c + 1), vertex(r + 1, c), vertex(r + 1, c + 1));
            for [p0, p1, p2] in [[a, e, f], [a, f, b]] {
                let (e1, e2) = (p1 - p0, p2 - p0);
                let n = e1.cross(e2);
                let facing = n.dot(d);
                if !(facing < 0.0) {
                    continue;
                }
                let t = n.dot(p0 - origin) / facing;
                let x = origin + t * d - p0;
                let (u, v) = (x.cross(e2).dot(n) / n.dot(n), e1.cross(x).dot(n) / n.dot(n));
                if t > 1e-9 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && nearest.is_none_or(|m| t < m) {
                    nearest = Some(t);
                }
            }
        }
    }
    nearest
}

#[test]
fn march_equals_exhaustive_search() {
    for gaps in [false, true] {
        let map = rough(37, 23, Edges::Open, gaps);
        let field = HeightField::new(&map);
        let mut rng = CounterRng::new(5, 1, 0);
        let mut hits = 0;
        for _ in 0..4000 {
            let (column, row) = (rng.uniform() * 36.0, rng.uniform() * 22.0);
            let phi = rng.uniform() * std::f64::consts::TAU;
            // From steep to grazing, downwards.
            let d = -direction(1.55 * rng.uniform().sqrt(), phi);
            let z = 3.0001;
            let fate = field.trace(Ray { column, row, z, direction: d }, None);
            let truth = exhaustive(&map, DVec3::new(column, -row * 1.7, z), d);
            match (fate, truth) {
                (Fate::Hit(hit), Some(t)) => {
                    hits += 1;
                    assert!((hit.z - (z + t * d.z)).abs() < 1e-9, "{hit:?} {t}");
                    assert!((hit.column - (column + t * d.x)).abs() < 1e-9);
                    let on_surface = field.height_at(hit.column, hit.row).unwrap();
                    assert!((on_surface - hit.z).abs() < 1e-7);
                }
                (Fate::Escaped(_) | Fate::Lost, None) => {}
                (fate, truth) => panic!("{fate:?} but {truth:?} from {column} {row} along {d}"),
            }
        }
        assert!(hits > 2000);
    }
}

#[test]
fn rays_leaving_a_facet_see_the_same_obstacles() {
    let map = rough(31, 29, Edges::Open, false);
    let field = HeightField::new(&map);
    let mut rng = CounterRng::new(9, 1, 0);
    let (mut blocked, mut free) = (0, 0);
    for _ in 0..4000 {
        let (c, r) = ((rng.uniform() * 30.0) as usize, (rng.uniform() * 28.0) as usize);
        let upper = rng.uniform() < 0.5;
        let (u, v) = if upper { (2.0 / 3.0, 1.0 / 3.0) } else { (1.0 / 3.0, 2.0 / 3.0) };
        let (column, row) = (c as f64 + u, r as f64 + v);
        let z = field.height_at(column, row).unwrap();
        let d = direction(1.4 * rng.uniform(), rng.uniform() * std::f64::consts::TAU);
        let fate = field.trace(Ray { column, row, z, direction: d }, Some(([c, r], upper)));
        // The exhaustive search sees the own facet only if the direction goes into it; such beams are not emitted.
        let slopes = asperity::facets::slopes::of_corners(
            [[r, c], [r, c + 1], [r + 1, c], [r + 1, c + 1]].map(|i| f64::from(map.heights[i])),
            1.0,
            1.7,
        )[usize::from(upper)];
        if asperity::math::frame::normal_of_slope(slopes.0, slopes.1).dot(d) <= 1e-3 {
            continue;
        }
        let truth = exhaustive(&map, DVec3::new(column, -row * 1.7, z), d);
        assert_eq!(matches!(fate, Fate::Hit(_)), truth.is_some(), "{c} {r} {upper} {d}");
        if truth.is_some() { blocked += 1 } else { free += 1 }
    }
    assert!(blocked > 300 && free > 300);
}

/// A periodic map and the same map tiled 5 x 5 and open must agree for rays that stay inside the tiling.
#[test]
fn periodic_and_mirrored_edges_equal_explicit_tiling() {
    for edges in [Edges::Periodic, Edges::Mirrored] {
        let map = rough(9, 7, edges, false);
        let tile = HeightField::new(&map);
        let (w, h) = (tile.cells()[0] as i64, tile.cells()[1] as i64);
        let fold = |k: i64, n: i64, samples: i64| -> usize {
            let m = match edges {
                Edges::Mirrored => {
                    let q = k.rem_euclid(2 * n);
                    if q > n { 2 * n - q } else { q }
                }
                _ => k.rem_euclid(n),
            };
            assert!(m < samples);
            m as usize
        };
        let tiled = HeightMap {
            heights: Array2::from_shape_fn(((5 * h + 1) as usize, (5 * w + 1) as usize), |(r, c)| {
                map.heights[[fold(r as i64 - 2 * h, h, 7), fold(c as i64 - 2 * w, w, 9)]]
            }),
            edges: Edges::Open,
            ..map.clone()
        };
        let big = HeightField::new(&tiled);
        let mut rng = CounterRng::new(3, 1, 0);
        let mut crossed = 0;
        for _ in 0..3000 {
            let (column, row) = (rng.uniform() * w as f64, rng.uniform() * h as f64);
            let d = -direction(1.35 * rng.uniform(), rng.uniform() * std::f64::consts::TAU);
            let a = tile.trace(Ray { column, row, z: 3.0, direction: d }, None);
            let b = big
                .trace(Ray { column: column + 2.0 * w as f64, row: row + 2.0 * h as f64, z: 3.0, direction: d }, None);
            let (Fate::Hit(a), Fate::Hit(b)) = (a, b) else { panic!("{a:?} {b:?}") };
            if edges == Edges::Mirrored {
                // The mirrored diagonal runs the other way in the explicit tiling: heights differ inside odd tiles.
                if a.flip != [1.0, 1.0] {
                    crossed += 1;
                    continue;
                }
            } else if b.column < 2.0 * w as f64 || b.column > 3.0 * w as f64 {
                crossed += 1;
            }
            assert!((a.z - b.z).abs() < 1e-9);
        }
        assert!(crossed > 100);
    }
}

/// Surfaces on which strides are long, short, forbidden, or along edges.
fn surfaces() -> Vec<(&'static str, HeightMap)> {
    let grid = synth::Grid { width: 150, height: 110, pitch: [1.0, 1.7] };
    let smooth = synth::gaussian(grid, synth::Gaussian { sq: 2.0, acl: 12.0, seed: 4, exact: true }).unwrap();
    let smooth = smooth.heights.mapv(|h| h as f32);
    let whole = synth::Grid { width: 96, height: 64, pitch: [1.0, 1.7] };
    let whole = synth::gaussian(whole, synth::Gaussian { sq: 2.5, acl: 12.0, seed: 5, exact: true }).unwrap();
    let whole_blocks = whole.heights.mapv(|h| h as f32);
    let map = |heights: Array2<f32>, edges| HeightMap {
        heights,
        pitch_x: 1.0,
        pitch_y: 1.7,
        edges,
        removed_slopes: [0.0; 2],
    };
    let with = |change: &dyn Fn(usize, usize, f32) -> f32, edges| {
        map(Array2::from_shape_fn((110, 150), |(r, c)| change(r, c, smooth[[r, c]])), edges)
    };
    vec![
        ("smooth, open", with(&|_, _, h| h, Edges::Open)),
        ("smooth, periodic", with(&|_, _, h| h, Edges::Periodic)),
        ("smooth, periodic in whole blocks", map(whole_blocks.clone(), Edges::Periodic)),
        ("smooth, periodic in few blocks", map(whole_blocks.slice(s![..16, ..24]).to_owned(), Edges::Periodic)),
        ("smooth, mirrored", with(&|_, _, h| h, Edges::Mirrored)),
        ("far from zero", with(&|_, _, h| 1e4 + h, Edges::Periodic)),
        ("one spike", with(&|r, c, h| if (r, c) == (50, 70) { h + 100.0 } else { h }, Edges::Periodic)),
        ("walls", with(&|r, c, _| if (r / 13 + c / 17) % 2 == 0 { 0.0 } else { 9.0 }, Edges::Periodic)),
        ("steps", with(&|_, _, h| (h * 2.0).round() / 2.0, Edges::Periodic)),
        ("gaps", with(&|r, c, h| if (r * 31 + c * 17) % 211 == 0 { f32::NAN } else { h }, Edges::Open)),
        ("many gaps", rough(61, 47, Edges::Periodic, true)),
        ("rough", rough(61, 47, Edges::Mirrored, false)),
        ("flat", with(&|_, _, _| 0.25, Edges::Open)),
        ("ramp", with(&|r, c, _| 0.1 * c as f32 - 0.3 * r as f32, Edges::Open)),
        ("one cell", map(Array2::from_shape_fn((2, 2), |(r, c)| (r + 2 * c) as f32), Edges::Periodic)),
        ("one row of cells", map(Array2::from_shape_fn((2, 90), |(r, c)| ((c + r) % 9) as f32), Edges::Mirrored)),
    ]
}

/// A ray and the facet that it leaves.
type Started = (Ray, Option<([usize; 2], bool)>);

/// The beam that leaves the facet of a hit as a mirror sends it on.
fn reflected(hit: &Hit, d: DVec3) -> Started {
    let back = -d * DVec3::new(hit.flip[0], hit.flip[1], 1.0);
    let direction = frame::reflect(back, frame::normal_of_slope(hit.slope.0, hit.slope.1));
    (Ray { column: hit.column, row: hit.row, z: hit.z, direction }, Some((hit.cell, hit.upper)))
}

/// The same facet, met at the same place but for the rounding of places several tiles away.
fn are_same(a: &Fate, b: &Fate) -> bool {
    match (a, b) {
        (Fate::Hit(a), Fate::Hit(b)) => {
            let apart = [a.column - b.column, a.row - b.row, (a.z - b.z) / (1.0 + a.z.abs())];
            apart.iter().all(|x| x.abs() < 1e-10)
                && (a.cell, a.upper, a.slope, a.flip) == (b.cell, b.upper, b.slope, b.flip)
        }
        _ => a == b,
    }
}

/// Packets against single rays: from above at all inclinations, on from where these hit, and from centroids of facets.
#[test]
fn packets_equal_single_rays() {
    let mut packet = Packet::default();
    for (name, map) in surfaces() {
        let field = HeightField::new(&map);
        let [_, top] = field.height_range();
        let [nx, ny] = field.cells();
        let mut rng = CounterRng::new(7, 0, 0);
        let (mut hits, mut seconds, mut free) = (0, 0, 0);
        let mut compare = |rays: &[Started]| -> Vec<Fate> {
            rays.iter().for_each(|&(ray, own)| packet.push(&field, ray, own));
            let fates = packet.trace(&field).to_vec();
            for (fate, &(ray, own)) in fates.iter().zip(rays) {
                let alone = field.trace(ray, own);
                assert!(are_same(fate, &alone), "{name}: {ray:?} {own:?}: {fate:?} {alone:?}");
            }
            fates
        };
        let mut above = Vec::new();
        for k in 0..6000 {
            let theta = [0.0, 0.3, 1.0, 1.3, 1.5, 1.56][k % 6] * if k < 3000 { 1.0 } else { rng.uniform() };
            // Along the axes and the diagonal as well.
            let phi = if k % 5 == 0 {
                (k / 5 % 8) as f64 * 0.25 * std::f64::consts::PI
            } else {
                std::f64::consts::TAU * rng.uniform()
            };
            let place = [rng.uniform() * nx as f64, rng.uniform() * ny as f64];
            // Half of them aimed at a vertex.
            let place = if k % 2 == 0 { place } else { place.map(f64::floor) };
            above.push((Ray { column: place[0], row: place[1], z: top, direction: -direction(theta, phi) }, None));
        }
        let mut onward = Vec::new();
        for (fate, (ray, _)) in compare(&above).iter().zip(&above) {
            if let Fate::Hit(hit) = fate {
                hits += 1;
                onward.push(reflected(hit, ray.direction));
            }
        }
        let mut again = Vec::new();
        for (fate, (ray, _)) in compare(&onward).iter().zip(&onward) {
            match fate {
                Fate::Hit(hit) => {
                    seconds += 1;
                    again.push(reflected(hit, ray.direction));
                }
                _ => free += 1,
            }
        }
        compare(&again);
        let mut centroids = Vec::new();
        for _ in 0..6000 {
            let cell = [rng.uniform() * nx as f64, rng.uniform() * ny as f64].map(|x| x as usize);
            let upper = rng.uniform() < 0.5;
            let corners = field.corners(cell[0], cell[1]).map(f64::from);
            let (p, q) = slopes::of_corners(corners, map.pitch_x, map.pitch_y)[usize::from(upper)];
            let d = direction(1.56 * rng.uniform().sqrt(), std::f64::consts::TAU * rng.uniform());
            if !(frame::normal_of_slope(p, q).dot(d) > 0.0) {
                continue;
            }
            let third = corners[if upper { 1 } else { 2 }];
            let (u, v) = if upper { (2.0 / 3.0, 1.0 / 3.0) } else { (1.0 / 3.0, 2.0 / 3.0) };
            let (column, row) = (cell[0] as f64 + u, cell[1] as f64 + v);
            let z = (corners[0] + corners[3] + third) / 3.0;
            centroids.push((Ray { column, row, z, direction: d }, Some((cell, upper))));
        }
        compare(&centroids);
        println!("{name}: {hits} hits, {seconds} second hits, {free} free");
        assert!(hits > 500, "{name}: {hits}");
        if name.starts_with("smooth") && !name.contains("few") {
            assert!(seconds > 50 && free > 2000, "{name}: {seconds} {free}");
        }
    }
}

/// A beam that meets something is never let go by what is known of blocks, and its hit lies within the way that is of interest; most of
/// those that meet nothing are let go.
#[test]
fn no_beam_that_meets_something_is_let_go() {
    let mut dropped = 0;
    for (name, map) in surfaces() {
        let field = HeightField::new(&map);
        let [nx, ny] = field.cells();
        let mut rng = CounterRng::new(13, 0, 0);
        let (mut starts, mut fates) = (Starts::default(), Vec::new());
        for _ in 0..5000 {
            let cell = [rng.uniform() * nx as f64, rng.uniform() * ny as f64].map(|x| x as usize);
            let upper = rng.uniform() < 0.5;
            let [a, b, c, d] = field.corners(cell[0], cell[1]).map(f64::from);
            let (p, q) = slopes::of_corners([a, b, c, d], map.pitch_x, map.pitch_y)[usize::from(upper)];
            let direction = direction(1.57 * rng.uniform().sqrt(), std::f64::consts::TAU * rng.uniform());
            if !(frame::normal_of_slope(p, q).dot(direction) > 0.0) {
                continue;
            }
            let (u, v) = if upper { (2.0 / 3.0, 1.0 / 3.0) } else { (1.0 / 3.0, 2.0 / 3.0) };
            let (column, row) = (cell[0] as f64 + u, cell[1] as f64 + v);
            let z = (a + d + if upper { b } else { c }) / 3.0;
            starts.push(&Start {
                id: fates.len() as u32,
                cell: cell.map(|c| c as u32),
                own: 1 + u32::from(upper),
                at: [u as f32, v as f32],
                z: z as f32,
                direction: direction.to_array().map(|x| x as f32),
                end: 0.0,
            });
            fates.push((field.trace(Ray { column, row, z, direction }, Some((cell, upper))), z, direction));
        }
        starts.keep_doubtful(Level::new(), &field);
        let mut kept = vec![None; fates.len()];
        (0..starts.n).for_each(|k| kept[starts.id[k] as usize] = Some(starts.end[k]));
        for (k, ((fate, z, direction), end)) in fates.iter().zip(kept).enumerate() {
            match (fate, end) {
                (Fate::Hit(hit), end) => {
                    let times = (hit.z - z) / direction.z;
                    assert!(end.is_some_and(|end| f64::from(end) >= times), "{name} {k}: {hit:?} {direction} {end:?}");
                }
                (_, None) => dropped += 1,
                _ => {}
            }
        }
    }
    assert!(dropped > 10_000, "{dropped}");
}
