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
