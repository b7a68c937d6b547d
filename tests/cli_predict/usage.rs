//! Wrong calls: exit code 2, a word about what is expected, and no file touched.

use super::{asperity, listing, synth, words};

#[test]
fn usage_errors_give_2() {
    let dir = tempfile::tempdir().unwrap();
    let (map, out) = (dir.path().join("a.x3p"), dir.path().join("out"));
    synth(&map, "0.2um", "1");
    let wrong: [&[&str]; 14] = [
        &["--material", "glue"],
        &["--material", "n=0.5"],
        &["--wavelength", "550"],
        &["--theta-i", "20,10"],
        &["--theta-i", "95"],
        &["--phi-i", "10,400"],
        &["--method", "magic"],
        &["--tolerance", "2"],
        &["--rays", "0"],
        &["--bounces", "0"],
        &["--spp", "0"],
        &["--tile-width", "10"],
        &["--exposure", "-1"],
        &["--pitch", "0um"],
    ];
    for flags in wrong {
        let mut call = words(&[&"predict", &map, &"-o", &out]);
        let flags_os = flags.iter().map(std::ffi::OsStr::new);
        call.extend(flags_os);
        let run = asperity(call);
        assert_eq!(run.code, 2, "{flags:?}: {}", run.stderr);
        assert_eq!(run.errors().len(), 1, "{flags:?}: {}", run.stderr);
        assert_eq!(run.stdout, "", "{flags:?}");
        assert!(!out.exists(), "{flags:?} left a folder");
    }
    assert_eq!(listing(dir.path()), ["a.x3p"]);
}

#[test]
fn incomplete_calls_give_2_and_help_gives_0() {
    let wrong: [&[&str]; 6] =
        [&[], &["predict"], &["predict", "a.x3p"], &["foretell"], &["gloss"], &["synth", "-o", "a.x3p", "--sq", "1"]];
    for call in wrong {
        let run = asperity(call);
        assert_eq!(run.code, 2, "{call:?}: {}", run.stderr);
        assert_eq!(run.stdout, "");
        assert!(!run.stderr.is_empty());
    }
    for call in [["--help"].as_slice(), &["--version"], &["predict", "--help"]] {
        let run = asperity(call);
        assert_eq!(run.code, 0);
        assert!(run.stdout.len() > 10 && run.stderr.is_empty());
    }
}

#[test]
fn every_share_takes_a_sign_or_a_fraction() {
    let dir = tempfile::tempdir().unwrap();
    let map = dir.path().join("a.npy");
    let out = dir.path().join("s.toml");
    let scene = "[camera]\nkind = \"orthographic\"\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\nheight = 1\n\
                 [sky]\nradiance = 1\n[materials.a]\nrgb = 0.5\n[[shapes]]\nkind = \"sphere\"\ncentre = [0, 0, 0]\nradius = 0.2\n\
                 material = \"a\"\n";
    std::fs::write(&out, scene).unwrap();
    let png = dir.path().join("p.png");
    for (share, more) in [("5%", "10%"), ("0.05", "0.1")] {
        let made = asperity(words(&[&"synth", &"-o", &map, &"--size", &"64", &"--acl", &"4um", &"--dropouts", &share]));
        assert_eq!(made.code, 0, "{}", made.stderr);
        let given = ["--fill", more, "--pitch", "1um", "--unit", "m"];
        let filled =
            asperity(words(&[&"inspect", &map, &given[0], &given[1], &given[2], &given[3], &given[4], &given[5]]));
        assert_eq!(filled.code, 0, "{}", filled.stderr);
        let size = ["--width", "16", "--height", "16", "--spp", "64"];
        let seen = asperity(words(&[
            &"render", &out, &"-o", &png, &"--error", &share, &size[0], &size[1], &size[2], &size[3], &size[4],
            &size[5],
        ]));
        assert_eq!(seen.code, 0, "{}", seen.stderr);
    }
    let calls: [&[&str]; 5] = [
        &["synth", "-o", "a.npy", "--dropouts", "5"],
        &["inspect", "a.npy", "--fill", "5"],
        &["render", "s.toml", "-o", "a.png", "--error", "5"],
        &["gloss", "mirror", "--tolerance", "5"],
        &["fit", "mirror", "--model", "ward", "--error-floor", "5"],
    ];
    for call in calls {
        let run = asperity(call);
        assert!(run.code == 2 && run.stderr.contains("write 5% or 0.05"), "{call:?}: {}", run.stderr);
    }
}

#[test]
fn a_table_is_no_map_and_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let (map, table) = (dir.path().join("a.x3p"), dir.path().join("T.npz"));
    synth(&map, "0.2um", "1");
    assert_eq!(asperity(words(&[&"brdf", &map, &"-o", &table])).code, 0);
    let before = std::fs::read(&table).unwrap();
    let (other, folder) = (dir.path().join("b.npz"), dir.path().join("out"));
    let picture = dir.path().join("c.png");
    let calls: [Vec<&std::ffi::OsStr>; 4] = [
        words(&[&"inspect", &table]),
        words(&[&"brdf", &table, &"-o", &other]),
        words(&[&"convert", &table, &"-o", &picture, &"--pitch", &"1um", &"--unit", &"um"]),
        words(&[&"predict", &table, &"-o", &folder]),
    ];
    for call in calls {
        let run = asperity(&call);
        assert_eq!(run.code, 1, "{call:?}: {}", run.stderr);
        assert_eq!(run.errors().len(), 1, "{}", run.stderr);
        assert!(
            run.stderr.contains("T.npz: this is a BRDF table, not a height map; give it to gloss"),
            "{}",
            run.stderr
        );
    }
    assert_eq!(std::fs::read(&table).unwrap(), before);
}

#[test]
fn numbers_that_would_take_the_machine_are_refused() {
    let calls: [&[&str]; 7] = [
        &["correspondence", "ggx:n=1.5", "--vary", "alpha=0.1..0.2", "--steps", "2", "--chart", "a.svg"],
        &["sample", "mirror", "--theta-i", "20", "-n", "99999999999999", "-o", "a.npy"],
        &["sample", "mirror", "--theta-i", "20", "-n", "0", "-o", "a.npy"],
        &["gloss", "mirror", "--threads", "100000"],
        &["gloss", "mirror", "--threads", "0"],
        &["inspect", "a.x3p", "--wavelength", "0nm"],
        &["scan", "mirror", "--chart", "a.jpg"],
    ];
    for call in calls {
        let run = asperity(call);
        assert_eq!(run.code, 2, "{call:?}: {}", run.stderr);
        assert_eq!(run.errors().len(), 1, "{}", run.stderr);
    }
    // Counts may be written as people write them.
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("a.npy");
    assert_eq!(asperity(words(&[&"sample", &"mirror", &"--theta-i", &"20", &"-n", &"1e3", &"-o", &out])).code, 0);
    assert_eq!(std::fs::metadata(&out).unwrap().len(), 128 + 1000 * 40);
}

#[test]
fn the_page_on_scenes_is_json_if_asked() {
    let page = asperity(["render", "--explain"]);
    let object = asperity(["render", "--explain", "--json"]).json();
    assert_eq!(object["markdown"].as_str(), Some(page.stdout.as_str()));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_stdout_is_one_error() {
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let mut call = std::process::Command::new(env!("CARGO_BIN_EXE_asperity"));
    let out = call.arg("models").stdout(full).output().unwrap();
    let words = String::from_utf8(out.stderr).unwrap();
    assert_eq!(out.status.code(), Some(1), "{words}");
    assert!(words.starts_with("error: the output cannot be written") && words.lines().count() == 1, "{words}");
}
