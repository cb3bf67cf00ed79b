//! Bad input ends in one clear line and a non-zero exit, and nothing is overwritten or lost.

mod support;

use support::Workplace;

/// Runs `line`, demands exit code 2, exactly one error line that mentions every one of `words`, and no new file.
fn refused(workplace: &Workplace, line: &str, words: &[&str]) {
    let before = workplace.files().len();
    let run = workplace.tamis(line);
    assert_eq!(run.code(), Some(2), "tamis {line}\n{}", run.stderr());
    let errors = run.errors();
    assert_eq!(errors.len(), 1, "tamis {line}\n{}", run.stderr());
    for word in words {
        assert!(errors[0].contains(word), "'{word}' is not in: {}", errors[0]);
    }
    assert!(!run.stderr().contains("panicked"), "{}", run.stderr());
    assert_eq!(workplace.files().len(), before, "tamis {line} left a file behind");
}

#[test]
fn scenes_that_are_none() {
    let workplace = Workplace::new();
    workplace.write("empty.obj", "");
    workplace.write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    workplace.write("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 one 0\nf 1 2 3\n");
    workplace.write("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n");
    workplace.write(
        "key.toml",
        "[camera]\neye = [0, 1, 5]\nlook_at = [0, 1, 0]\nfow = 30\n[[geometry]]\nfile = \"box.obj\"\n",
    );
    workplace.write("none.toml", "[render]\nspp = 0\n[[geometry]]\nfile = \"box.obj\"\n");
    std::fs::create_dir(workplace.path("folder.obj")).unwrap();
    refused(&workplace, "render absent.obj -o a.exr", &["absent.obj"]);
    for line in ["render absent.obj -o a.exr", "info absent.obj", "render box.obj --env absent.hdr -o a.exr"] {
        assert!(workplace.tamis(line).stderr().trim_end().ends_with(": no such file"), "{line}");
    }
    refused(&workplace, "render folder.obj -o a.exr", &["folder.obj", "folder"]);
    refused(&workplace, "render empty.obj -o a.exr", &["empty.obj"]);
    refused(&workplace, "render points.obj -o a.exr", &["points.obj", "face"]);
    refused(&workplace, "render broken.obj -o a.exr", &["broken.obj", "3"]);
    refused(&workplace, "render range.obj -o a.exr", &["range.obj", "4"]);
    refused(&workplace, "render key.toml -o a.exr", &["key.toml", "4", "fow", "fov"]);
    refused(&workplace, "render none.toml -o a.exr", &["none.toml:2", "at least 1 sample"]);
    workplace.write("preset.toml", "[render]\npreset = \"fats\"\n[[geometry]]\nfile = \"box.obj\"\n");
    refused(&workplace, "render preset.toml -o a.exr", &["preset.toml:2", "best, fast, paper", "'fats'"]);
    refused(&workplace, "render box.mtl -o a.exr", &["box.mtl"]);
}

#[test]
fn flags_that_are_wrong() {
    let workplace = Workplace::new();
    for line in ["--size 0x10", "--size 10", "--eye 1,2", "--crop 0,0,0,5", "--samples 5..5", "--time 5"] {
        refused(&workplace, &format!("render box.obj -o a.exr {line}"), &[line.split(' ').next().unwrap()]);
    }
    for flag in ["--target-error", "--exposure", "--env-scale"] {
        refused(&workplace, &format!("render box.obj -o a.exr {flag} nan"), &[flag, "finite"]);
    }
    for spp in [0, -1] {
        refused(&workplace, &format!("render box.obj -o a.exr --spp {spp}"), &["--spp", "1..="]);
    }
    for (flag, expected) in [
        ("--env -1,0,0", "at least 0"),
        ("--env-scale -1", "at least 0"),
        ("--target-error -1", "above 0"),
        ("--crop -1,0,2,2", "x and y from 0"),
        ("--size -3x5", "a width and a height"),
        ("--samples -1..3", "A below B"),
        ("--time -5s", "a number and s, m or h"),
    ] {
        refused(&workplace, &format!("render box.obj -o a.exr {flag}"), &[expected]);
    }
    for flag in ["--max-rmse", "--max-flip"] {
        for limit in ["-1", "nan"] {
            refused(&workplace, &format!("compare a.exr b.exr {flag} {limit}"), &[flag, "at least 0"]);
        }
    }
    refused(&workplace, "render box.obj -o a.gif", &["a.gif", ".exr"]);
    refused(&workplace, "render box.obj -o a.exr --spike-tile-size 1", &["--spike-tile-size", "4..=1024"]);
    refused(&workplace, "render box.obj -o a.exr --size 32x32 --crop 30,0,5,5", &["--crop"]);
    refused(&workplace, "render box.obj -o a.exr --aov mse,depth", &["--aov", "depth"]);
    let run = workplace.tamis("render box.obj --max-dept 3");
    assert_eq!(run.code(), Some(2));
    assert!(run.stderr().contains("--max-depth"), "the nearest flag is named:\n{}", run.stderr());
}

#[test]
fn an_output_that_cannot_be_written_is_found_before_the_tracing() {
    let workplace = Workplace::new();
    // Sixteen million samples a pixel would take years: only a check beforehand can answer.
    let run = workplace.tamis("render box.obj --spp 60000 --size 4000x4000 -o absent/a.exr");
    assert_eq!(run.code(), Some(2), "{}", run.stderr());
    assert_eq!(run.errors().len(), 1);
    assert!(run.errors()[0].contains("absent/a.exr"));
}

#[test]
fn stacks_that_are_none() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 24x16 --spp 4 -o a.exr --quiet");
    let whole = workplace.bytes("a.exr");
    std::fs::write(workplace.path("cut.exr"), &whole[..whole.len() / 2]).unwrap();
    workplace.write("text.exr", "this is no picture");
    refused(&workplace, "denoise cut.exr -o b.exr", &["cut.exr", "OpenEXR"]);
    refused(&workplace, "denoise text.exr -o b.exr", &["text.exr", "OpenEXR"]);
    refused(&workplace, "denoise absent.exr -o b.exr", &["absent.exr"]);
    refused(&workplace, "denoise . -o b.exr", &["folder"]);
    refused(&workplace, "denoise a.exr", &["-o"]);
    refused(&workplace, "denoise --buckets a.exr a.exr -o b.exr", &["seed 0", "count once"]);
    refused(&workplace, "denoise a.exr -o b.exr --require shadow", &["shadow"]);
    refused(&workplace, "compare a.exr text.exr", &["text.exr"]);
    refused(&workplace, "info text.exr", &["text.exr"]);
    workplace.must("denoise a.exr -o done.exr --aov none --quiet");
    refused(&workplace, "denoise done.exr -o b.exr", &["done.exr", "finished picture", "--aov inputs"]);
    assert!(workplace.must("info done.exr").stdout().contains("24x16"), "what it holds can be told");
    without_colour(&workplace);
    refused(&workplace, "denoise grey.exr -o b.exr", &["grey.exr", "colour", "R G B"]);
}

fn without_colour(workplace: &Workplace) {
    let mut layers = stack::file::Layers::read(&workplace.path("a.exr")).unwrap();
    layers.metadata = None;
    layers.channels.retain(|channel| channel.name.starts_with("depth"));
    layers.write(&workplace.path("grey.exr")).unwrap();
}

#[test]
fn a_missing_texture_is_said_and_its_colour_used() {
    let workplace = Workplace::new();
    workplace.write(
        "box.mtl",
        "newmtl white\nKd .7 .7 .7\nmap_Kd absent.png\nnewmtl red\nKd .6 .1 .1\nnewmtl lamp\nKe 9 9 9\n",
    );
    let run = workplace.must("render box.obj --size 16x16 --spp 2 -o a.exr");
    assert!(run.stderr().contains("absent.png"), "{}", run.stderr());
}

#[test]
fn a_failed_run_leaves_the_finished_picture_alone() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 16x16 --spp 2 -o a.exr --quiet");
    let finished = workplace.bytes("a.exr");
    workplace.write("box.obj", "f 1 2 3\n");
    assert_eq!(workplace.tamis("render box.obj --size 16x16 --spp 2 -o a.exr").code(), Some(2));
    assert_eq!(workplace.bytes("a.exr"), finished);
}
