//! Scene files: what they build, and what they say when they cannot.

use asperity::model;
use asperity::optics::Brdf;
use asperity::render::description::Wanted;
use asperity::render::{Description, RenderWarning, render};
use asperity::{Error, Result};
use std::path::Path;
use std::process::Command;

const GOOD: &str = r#"
length_unit = "mm"
[camera]
kind = "perspective"
position = [0, -500, 200]
look_at = [0, 0, 20]
field_of_view_deg = 14
[image]
width = 40
height = 30
samples = 16
depth = 4
exposure = 2
[sky]
radiance = [0.2, 0.3, 0.4]
[materials.glass]
source = "beckmann:alpha=0.05,n=1.5"
[materials.gold]
source = "ggx:alpha=0.2,material=au"
tint = 0.9
[materials.wall]
rgb = [0.8, 0.7, 0.6]
[materials.floor]
checker = { a = "wall", b = 0.1, size = 20 }
[[shapes]]
kind = "quad"
corner = [-200, -200, 0]
edge_u = [400, 0, 0]
edge_v = [0, 400, 0]
material = "floor"
[[shapes]]
kind = "sphere"
centre = [-30, 0, 20]
radius = 20
material = "glass"
[[shapes]]
kind = "revolution"
profile = [[0, 0], [15, 0], [20, 20], [8, 40]]
smooth = true
material = "gold"
transform = { scale = 1.2, rotate_deg = [0, 10, 30], translate = [30, 0, 5] }
[[shapes]]
kind = "disc"
centre = [0, 0, 300]
normal = [0, 0, -1]
radius = 40
power = 2.0
"#;

fn open(wanted: &Wanted) -> Result<Box<dyn Brdf>> {
    model::parse(wanted.source, wanted.wavelength)
}

/// Everything but the picture.
fn build(text: &str) -> Result<Vec<String>> {
    let description = Description::parse(text, Path::new("folder/s.toml"))?;
    let options = description.picturing()?.options();
    let camera = description.camera(options.width as f64 / options.height as f64)?;
    let materials = description.materials(&open, &|_| ())?;
    let built = description.build(&materials)?;
    let mut said = built.notes;
    said.extend(RenderWarning::of_scene(&built.scene, &camera).iter().map(ToString::to_string));
    let film = render(&built.scene, &camera, &options, &|_| ())?;
    said.extend(RenderWarning::of_film(&film, &built.scene).map(|w| w.to_string()));
    Ok(said)
}

fn message(text: &str) -> String {
    let error = build(text).expect_err(text);
    assert!(matches!(error, Error::Content { .. }), "{error}");
    error.to_string()
}

fn with(old: &str, new: &str) -> String {
    assert!(GOOD.contains(old), "{old}");
    GOOD.replacen(old, new, 1)
}

#[test]
fn a_good_scene_builds_without_a_word() {
    assert_eq!(build(GOOD).unwrap(), [""; 0]);
    let picturing = Description::parse(GOOD, Path::new("s.toml")).unwrap().picturing().unwrap();
    let options = picturing.options();
    assert_eq!((options.width, options.samples_per_pixel, options.max_reflections), (40, 16, 3));
    assert_eq!(picturing.exposure, Some(2.0));
}

/// The example on the page that explains scenes is a scene; the mesh it names is not there.
#[test]
fn the_page_is_true() {
    let page = asperity::render::description::PAGE;
    let text = page.split("```toml\n").nth(1).and_then(|t| t.split("```").next()).unwrap();
    let description = Description::parse(text, Path::new("s.toml")).unwrap();
    assert_eq!(description.picturing().unwrap().error, Some(0.02));
    description.camera(1.0).unwrap();
    // The map behind `method` and `surface` is opened by whoever calls.
    let said = message(text);
    assert!(said.contains("bunny.ply"), "{said}");
}

/// `L = Phi / (pi A)`, in whatever unit of length.
#[test]
fn power_becomes_radiance() {
    let text = "[camera]\nkind = \"orthographic\"\nposition = [0, 0, -1]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\nheight = 0.001\n\
        [image]\nwidth = 2\nheight = 2\nsamples = 1\n[[shapes]]\nkind = \"disc\"\ncentre = [0, 0, 0]\nnormal = [0, 0, -1]\n\
        radius = 0.5\npower = [1, 2, 3]\n";
    for (unit, scale) in [("m", 1.0), ("mm", 1e-3)] {
        let text = format!("length_unit = \"{unit}\"\n{text}");
        let description = Description::parse(&text, Path::new("s.toml")).unwrap();
        let materials = description.materials(&open, &|_| ()).unwrap();
        let built = description.build(&materials).unwrap();
        let options = description.picturing().unwrap().options();
        let film = render(&built.scene, &description.camera(1.0).unwrap(), &options, &|_| ()).unwrap();
        let area = std::f64::consts::PI * (0.5 * scale) * (0.5 * scale);
        for (k, power) in [1.0, 2.0, 3.0].into_iter().enumerate() {
            let expected = power / (std::f64::consts::PI * area);
            assert!((f64::from(film.pixels()[0].radiance[k]) / expected - 1.0).abs() < 1e-6, "{unit}");
        }
    }
}

/// Paint that reads the same at all angles is matt, in the colour of its tristimulus values (IEC 61966-2-1); under a coat it
/// loses what the coat takes on both ways.
#[test]
fn metallic_paint_shows_its_tristimulus_values() {
    let xyz = "[39.083, 35.659, 23.742]";
    let rgb = [0.6, 0.3, 0.2];
    let text = format!(
        "[camera]\nkind = \"orthographic\"\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\nheight = 1\n\
         [image]\nwidth = 2\nheight = 2\nsamples = 256\n[sky]\nradiance = 2\n\
         [materials.body]\nmetallic = {{ xyz_15 = {xyz}, xyz_45 = {xyz}, xyz_110 = {xyz} }}\n\
         [[shapes]]\nkind = \"disc\"\ncentre = [0, 0, 0]\nnormal = [0, 0, 1]\nradius = 5\nmaterial = \"body\"\n"
    );
    let show = |text: &str| {
        let description = Description::parse(text, Path::new("s.toml")).unwrap();
        let materials = description.materials(&open, &|_| ()).unwrap();
        let built = description.build(&materials).unwrap();
        let options = description.picturing().unwrap().options();
        render(&built.scene, &description.camera(1.0).unwrap(), &options, &|_| ()).unwrap().pixels()[0].radiance
    };
    for (shown, expected) in show(&text).into_iter().zip(rgb) {
        assert!((f64::from(shown) / (2.0 * expected) - 1.0).abs() < 1e-3, "{shown} {expected}");
    }
    let coat = model::parse("dielectric:n=1.5", 550e-9).unwrap();
    // Mean of what the coat lets through over the directions of a matt base, by midpoints in cos^2.
    let through =
        (0..2000).map(|k| 1.0 - coat.albedo(((f64::from(k) + 0.5) / 2000.0).sqrt().acos())).sum::<f64>() / 2000.0;
    let r0 = coat.albedo(0.0);
    let coated = text.replace("[[shapes]]", "coat = \"dielectric:n=1.5\"\n[[shapes]]");
    for (shown, matt) in show(&coated).into_iter().zip(rgb) {
        let expected = 2.0 * (r0 + (1.0 - r0) * matt * through);
        assert!((f64::from(shown) / expected - 1.0).abs() < 5e-3, "{shown} {expected}");
    }
}

#[test]
fn faults_are_named_by_line_and_key() {
    let line = |text: &str, needle: &str| {
        let number = text.lines().position(|l| l.contains(needle)).expect(needle) + 1;
        format!("line {number}:")
    };
    let green = "metallic = { xyz_15 = [10, 50, 10], xyz_45 = [5, 5, 5], xyz_110 = [5, 5, 5] }";
    // What is written instead of what, where the fault is found, and what the message says about it.
    let cases = [
        ("radius = 20\n", "rdius = 20\n", "rdius", "unknown field `rdius`"),
        ("radius = 20\n", "radius = 0\n", "radius = 0", "radius"),
        ("radius = 20\n", "radius = nan\n", "radius = nan", "radius"),
        ("radius = 20\n", "radius = \"big\"\n", "\"big\"", "invalid type"),
        ("radius = 20\n", "", "kind = \"sphere\"", "no `radius`"),
        ("radius = 20\n", "radius = 20\ncorner = [0, 0, 0]\n", "corner = [0, 0, 0]", "does not belong to a sphere"),
        ("edge_v = [0, 400, 0]", "edge_v = [400, 0, 0]", "edge_v", "no area"),
        ("edge_v = [0, 400, 0]", "edge_v = [0, 400]", "edge_v = [0, 400]", "array of length 3"),
        ("material = \"glass\"", "material = \"glas\"", "\"glas\"", "no material `glas`"),
        ("material = \"glass\"\n", "", "kind = \"sphere\"", "neither a material nor a radiance"),
        ("power = 2.0", "power = 0", "power = 0", "power"),
        ("power = 2.0", "power = -1", "power = -1", "power"),
        ("power = 2.0", "power = 2.0\nradiance = 1", "kind = \"disc\"", "more than one"),
        ("radius = 40", "radius = 40\ninner_radius = 40", "radius = 40", "no area"),
        ("kind = \"disc\"", "kind = \"disk\"", "\"disk\"", "unknown variant `disk`"),
        ("kind = \"perspective\"", "kind = \"orthographic\"", "field_of_view_deg", "has `height`"),
        ("look_at = [0, 0, 20]", "look_at = [0, -500, 200]", "position", "stands in the point"),
        ("radiance = [0.2, 0.3, 0.4]", "radiance = [0.2, -0.3, 0.4]", "radiance = [0.2", "negative"),
        ("radiance = [0.2, 0.3, 0.4]", "environment = \"none.exr\"", "environment", "none.exr"),
        ("rgb = [0.8, 0.7, 0.6]", "rgb = [0.8, 1.7, 0.6]", "1.7", "not a reflectance"),
        ("rgb = [0.8, 0.7, 0.6]", "rgb = \"red\"", "rgb = \"red\"", "expected a number or [r, g, b]"),
        ("tint = 0.9", "rgb = 0.9", "[materials.gold]", "needs one of"),
        ("alpha=0.05", "alpha=-1", "alpha=-1", "outside its range"),
        ("a = \"wall\"", "a = \"wal\"", "a = \"wal\"", "no material `wal`"),
        ("a = \"wall\"", "a = \"floor\"", "a = \"floor\"", "is a checker itself"),
        ("size = 20", "size = 0", "size = 0", "not above 0"),
        ("[15, 0]", "[-15, 0]", "-15", "point 1"),
        ("scale = 1.2", "scale = 0", "scale = 0", "transform"),
        ("length_unit = \"mm\"", "length_unit = \"mile\"", "mile", "no unit"),
        ("depth = 4", "depth = 0", "depth = 0", "at least one piece"),
        ("depth = 4", "estimator = \"magic\"", "magic", "unknown"),
        ("samples = 16", "samples = 0", "samples = 0", "at least one sample"),
        ("exposure = 2", "exposure = -2", "exposure = -2", "above 0"),
        ("width = 40", "width = 0", "width = 0", "65536"),
        ("exposure = 2", "error_percent = 0", "error_percent", "above 0"),
        ("tint = 0.9", "tint = 0.9\nwavelength_nm = -5", "wavelength_nm", "above 0"),
        ("tint = 0.9", "tint = 0.9\ncoat = \"mirror\"", "coat = ", "for metallic paint"),
        ("rgb = [0.8, 0.7, 0.6]", green, "metallic = ", "outside of sRGB"),
        ("tint = 0.9", green, "metallic = ", "needs one of"),
    ];
    for (old, new, place, what) in cases {
        let text = with(old, new);
        let said = message(&text);
        assert!(said.starts_with("folder/s.toml: "), "{said}");
        assert!(said.contains(&line(&text, place)) && said.contains(what), "{new}: {said}");
    }
    assert!(message("[camera]\nkind = ").contains("line 2:"));
    assert!(message("").contains("camera"));
}

#[test]
fn bad_meshes_name_the_line_and_the_file() {
    let mesh = |file: &str| {
        with("kind = \"sphere\"\ncentre = [-30, 0, 20]\nradius = 20", &format!("kind = \"mesh\"\nfile = \"{file}\""))
    };
    let missing = message(&mesh("gone.ply"));
    assert!(missing.contains("line ") && missing.contains("gone.ply") && missing.contains("`file`"), "{missing}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    let bad = message(&mesh(&path.display().to_string()));
    assert!(bad.contains("bad.obj") && bad.contains("`file`"), "{bad}");
}

#[test]
fn what_a_picture_hides_is_said() {
    let inside = build(&with("position = [0, -500, 200]", "position = [-30, 0, 21]")).unwrap();
    assert!(inside.iter().any(|w| w.contains("inside sphere 1")), "{inside:?}");
    let sky = "[sky]\nradiance = [0.2, 0.3, 0.4]\n";
    let lamp = &GOOD[GOOD.find("[[shapes]]\nkind = \"disc\"").unwrap()..];
    let dark = build(&GOOD.replace(sky, "").replace(lamp, "")).unwrap();
    assert!(dark.iter().any(|w| w.contains("Nothing shines")), "{dark:?}");
    let away = build(&GOOD.replace(sky, "").replace("normal = [0, 0, -1]", "normal = [0, 0, 1]")).unwrap();
    assert!(away.iter().any(|w| w.contains("black although something shines")), "{away:?}");
    let empty = build(&GOOD[..GOOD.find("[[shapes]]").unwrap()]).unwrap();
    assert!(empty.iter().any(|w| w.contains("no [[shapes]]")), "{empty:?}");
}

fn asperity(arguments: &[&str], folder: &Path) -> (bool, String, String) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_asperity")).args(arguments).current_dir(folder).output().expect("it starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    (output.status.success(), text(output.stdout), text(output.stderr))
}

/// A square of heights as numpy writes it.
fn npy(side: usize) -> Vec<u8> {
    let head = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({side}, {side}), }}");
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(format!("{head:<117}\n").bytes());
    let heights = (0..side * side).map(|k| ((k % side * 7 + k / side * 5) % 11) as f32 * 0.01);
    bytes.extend(heights.flat_map(f32::to_le_bytes));
    bytes
}

#[test]
fn the_command_renders_reads_back_and_refuses() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.toml"), GOOD).unwrap();
    let run = |arguments: &[&str]| asperity(arguments, folder.path());
    let (done, out, err) =
        run(&["--json", "render", "s.toml", "-o", "a.exr", "-o", "a.png", "--error", "5%", "--spp", "64"]);
    assert!(done, "{err}");
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!(json["samples"].as_u64().unwrap() > 0 && json["exposure"] == 2.0, "{out}");
    assert!(json["samples_saved"].as_f64().unwrap() >= 0.0 && json["longest_path"].as_u64().unwrap() <= 4, "{out}");
    let png = image::open(folder.path().join("a.png")).unwrap();
    assert_eq!((png.width(), png.height()), (40, 30));
    let (_, out, _) = run(&["--json", "render", "--read", "a.exr", "--pixel", "3,2"]);
    let read: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!(read["comment"].as_str().unwrap().contains("--seed 1"), "{out}");
    // The sky, less whatever the checker floor shows there: at the top left there is sky or floor, never black.
    assert!(read["pixels"][0]["radiance_w_per_m2_sr"][2].as_f64().unwrap() > 0.0, "{out}");
    let (same, _, _) = run(&["render", "s.toml", "-o", "b.exr", "--error", "5%", "--spp", "64", "--threads", "1"]);
    assert!(
        same && std::fs::read(folder.path().join("a.exr")).unwrap()
            == std::fs::read(folder.path().join("b.exr")).unwrap()
    );
    // A map without units is told them by the flags of its material.
    std::fs::write(folder.path().join("h.npy"), npy(64)).unwrap();
    let floor = |flags: &str| {
        let material = format!("[materials.map]\nsource = \"h.npy\"\n{flags}\n");
        let text = std::fs::read_to_string(folder.path().join("s.toml")).unwrap();
        std::fs::write(folder.path().join("m.toml"), format!("{text}{material}")).unwrap();
        run(&["render", "m.toml", "-o", "m.exr", "--spp", "1"])
    };
    let (done, _, err) = floor("");
    assert!(!done && err.contains("h.npy") && err.contains("--unit"), "{err}");
    let (done, _, err) = floor("flags = [\"--pitch=1um\", \"--unit=um\"]");
    assert!(done, "{err}");
    let (done, _, err) = floor("flags = [\"--pich=1um\"]");
    assert!(!done && err.contains("--pich") && err.contains("line"), "{err}");
    let (explained, page, _) = run(&["render", "--explain"]);
    assert!(explained && page.contains("field_of_view_deg") && page.contains("W/(m2 sr)"));
    for (arguments, what) in [
        (&["render", "none.toml", "-o", "c.exr"][..], "none.toml"),
        (&["render", "s.toml", "-o", "c.gif"][..], ".png or .exr"),
        (&["render", "s.toml"][..], "--output"),
        (&["render", "s.toml", "-o", "c.exr", "--error", "2"][..], "write 2% or 0.02"),
        (&["render", "s.toml", "-o", "c.exr", "--estimator", "magic"][..], "mis, brdf"),
        (&["render", "--read", "a.exr", "--pixel", "99,2"][..], "no pixel 99,2"),
        (&["render", "--read", "s.toml"][..], "s.toml"),
    ] {
        let (done, _, err) = run(arguments);
        assert!(!done && err.contains(what) && !err.contains("panicked"), "{arguments:?}: {err}");
        assert!(!folder.path().join("c.exr").exists());
    }
}
