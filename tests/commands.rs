//! What each command prints, and the shape of its JSON.

mod support;

use std::io::Write;
use std::process::Stdio;

use exr::prelude::FlatSamples;
use serde_json::Value;
use stack::file::{Layers, Passthrough};
use support::{Workplace, shared};

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn render_prints_one_json_object_and_nothing_else() {
    let workplace = Workplace::new();
    let run = workplace.must("render box.obj --size 32x24 --spp 8 -o a.exr --json");
    let report = json(&run.stdout());
    assert_eq!((report["width"].as_u64(), report["height"].as_u64()), (Some(32), Some(24)));
    assert_eq!(report["spp"]["mean"].as_f64(), Some(8.0));
    assert_eq!(report["samples"].as_u64(), Some(32 * 24 * 8));
    assert!(report["rays"].as_u64() > report["samples"].as_u64());
    assert!(report["estimated_rmse"].as_f64().is_some_and(|error| error > 0.0));
    for key in ["load", "build", "trace", "reconstruct", "write", "total"] {
        assert!(report["seconds"][key].is_number(), "{key}");
    }
    for key in ["spikes", "prefilter", "reduce", "bandwidth", "regression"] {
        assert!(report["stages"][key].is_number(), "{key}: {}", report["stages"]);
    }
    assert_eq!(report["iterations"].as_array().map(Vec::len), Some(4));
    let energy = |which: &str| report["energy"][which].as_f64().unwrap();
    assert!((energy("result") / energy("noisy") - 1.0).abs() < 0.1);
}

#[test]
fn what_a_render_left_out_is_counted() {
    let workplace = Workplace::new();
    workplace.write(
        "odd.obj",
        "mtllib odd.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nusemtl m\nf 1 2 3\nf 1 2 2\nf 1 2 4\nf 2 3 4\n",
    );
    workplace.write("odd.mtl", "newmtl m\nKd 1 1 1\nmap_Kd gone.png\nbump none.png\n");
    workplace.write(
        "odd.toml",
        "[[camera]]\nname = \"near\"\neye = [0, 0, 3]\nlook_at = [0, 0, 0]\n[[camera]]\nname = \"far\"\neye = [0, 0, 30]\n\
         look_at = [0, 0, 0]\n[[geometry]]\nfile = \"odd.obj\"\ninstances = [{}, { translate = [0, 0, -1] }]\n",
    );
    let render = |more: &str| {
        json(&workplace.must(&format!("render odd.toml --size 16x16 --spp 2 -o a.exr --json {more}")).stdout())
    };
    let report = render("--camera far");
    assert_eq!(report["triangles"], serde_json::json!({"total": 2, "stored": 1, "degenerate": 1, "not_finite": 2}));
    assert_eq!((report["textures_missing"].as_u64(), report["not_finite"].as_u64()), (Some(2), Some(0)));
    let pictures = ["--camera far", "--camera near", ""].map(|camera| {
        render(&format!("{camera} --uniform --no-denoise"));
        workplace.bytes("a.exr")
    });
    assert!(pictures[0] != pictures[1] && pictures[1] == pictures[2], "the first camera is the one used");
    let run = workplace.tamis("render odd.toml --camera middle -o a.exr");
    assert_eq!(run.code(), Some(2));
    assert!(run.errors()[0].contains("no camera 'middle'; it has: near, far"), "{}", run.stderr());
    let run = workplace.tamis("render odd.obj --camera middle -o a.exr");
    assert!(run.errors()[0].contains("'middle', and none that has a name"), "{}", run.stderr());
    let text = workplace.must("info odd.obj").stdout();
    assert!(text.contains("1 triangle, 3 dropped") && text.contains("1 material, "), "{text}");
}

#[test]
fn adaptive_sampling_spends_the_whole_budget() {
    let workplace = Workplace::new();
    let run = workplace.must("render box.obj --size 40x40 --spp 16 -o a.exr --json --quiet");
    let report = json(&run.stdout());
    assert_eq!(report["samples"].as_u64(), Some(40 * 40 * 16));
    assert!(report["spp"]["min"].as_u64() < report["spp"]["max"].as_u64());
}

#[test]
fn a_missed_target_is_a_negative_answer() {
    let workplace = Workplace::new();
    let run = workplace.tamis("render box.obj --size 16x16 --spp 2 --target-error 1e-12 -o a.exr");
    assert_eq!(run.code(), Some(1));
    let said = run.stderr();
    let line = said.lines().find(|line| line.contains("--target-error 1e-12 is not reached"));
    assert!(line.is_some_and(|line| line.contains("the estimate is ")), "{said}");
    workplace.must("render box.obj --size 16x16 --spp 4 --target-error 1e9 -o b.exr --quiet");
}

#[test]
fn what_is_reached_first_ends_a_render() {
    let workplace = Workplace::new();
    let rendered = |flags: &str| {
        let report = workplace.must(&format!("render box.obj --size 48x32 -o a.exr --json --quiet {flags}")).stdout();
        json(&report)["spp"]["mean"].as_f64().unwrap()
    };
    // So many samples would take minutes.
    for flags in ["--uniform", "--uniform --no-denoise", "--method ld"] {
        let spp = rendered(&format!("--spp 200000 --time 1s {flags}"));
        assert!((4.0..50_000.0).contains(&spp), "{flags}: {spp}");
    }
    assert!(rendered("--uniform --spp 4096 --target-error 1 --method ld") < 4096.0);
    assert_eq!(rendered("--uniform --spp 21 --time 1h --method ld"), 21.0);
}

#[test]
fn the_sky_may_be_a_picture_and_the_shutter_is_checked() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 16x8 --spp 1 --uniform --no-denoise --env .1,.2,.3 -o sky.exr --quiet");
    let render = |flags: &str, to: &str| {
        workplace.must(&format!("render box.obj --size 8x8 --spp 4 --uniform --no-denoise {flags} -o {to} --quiet"));
        workplace.bytes(to)
    };
    let turned = render("--env sky.exr --env-rotate -90 --env-scale 2", "a.exr");
    assert_eq!(turned, render("--env sky.exr --env-rotate -90 --env-scale 2 --threads 1", "b.exr"));
    assert_ne!(turned, render("--env sky.exr", "c.exr"));
    for (flags, said) in [("--env box.mtl", "box.mtl"), ("--env none.hdr", "none.hdr"), ("--shutter 1,0", "shutter")] {
        let run = workplace.tamis(&format!("render box.obj --size 8x8 --spp 1 {flags} -o d.exr"));
        assert!(run.code() == Some(2) && run.stderr().contains(said), "{}", run.stderr());
    }
}

#[test]
fn compare_measures_and_judges() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 32x32 --spp 4 --uniform --no-denoise -o noisy.exr --quiet");
    workplace.must("render box.obj --size 32x32 --spp 256 --uniform --no-denoise -o ref1.exr --quiet");
    workplace.must("render box.obj --size 32x32 --spp 256 --seed 1 --uniform --no-denoise -o ref2.exr --quiet");
    let run = workplace.must("compare ref1.exr noisy.exr ref1.exr --ref2 ref2.exr --json");
    let report = json(&run.stdout());
    let image = |i: usize, key: &str| report["images"][i][key].clone();
    assert!(image(0, "rmse").as_f64() > Some(0.0) && image(1, "rmse").as_f64() == Some(0.0));
    assert!(image(0, "rmse_cross").as_f64().unwrap() > image(1, "rmse_cross").as_f64().unwrap());
    for flip in ["flip", "flip_hdr"] {
        assert!((0.001..1.0).contains(&image(0, flip).as_f64().unwrap()));
        assert_eq!(image(1, flip).as_f64(), Some(0.0));
    }
    assert_eq!(image(0, "nan_pixels").as_u64(), Some(0));
    assert_eq!(workplace.tamis("compare ref1.exr noisy.exr --max-rmse 1e-9").code(), Some(1));
    assert_eq!(workplace.tamis("compare ref1.exr noisy.exr --max-rmse 1e9 --max-flip 1").code(), Some(0));
    assert_eq!(workplace.tamis("compare ref1.exr noisy.exr --max-flip 0.001").code(), Some(1));
    workplace.must("render box.obj --size 16x32 --spp 1 --no-denoise -o small.exr --quiet");
    let run = workplace.tamis("compare ref1.exr small.exr");
    assert_eq!((run.code(), run.errors().len()), (Some(2), 1));
}

#[test]
fn compare_leaves_out_what_the_mask_does() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 16x16 --spp 4 --uniform --no-denoise -o a.exr --quiet");
    workplace.must("render box.obj --size 16x16 --spp 4 --seed 1 --uniform --no-denoise -o b.exr --quiet");
    let mask: Vec<u8> = (0..256).flat_map(|i| [u8::from(i % 3 == 0) * 255; 3]).collect();
    let mut pfm = b"PF\n16 16\n-1.0\n".to_vec();
    pfm.extend(mask.iter().flat_map(|v| f32::from(*v).to_le_bytes()));
    std::fs::write(workplace.path("some.pfm"), pfm).unwrap();
    let rmse = |more: &str| {
        let report = json(&workplace.must(&format!("compare a.exr b.exr --json {more}")).stdout());
        report["images"][0]["rmse"].as_f64().unwrap()
    };
    assert!((rmse("--mask some.pfm") - rmse("")).abs() > 1e-6);
    let run = workplace.tamis("compare a.exr b.exr --mask absent.png");
    assert_eq!((run.code(), run.errors().len()), (Some(2), 1));
}

/// A name of bytes that are no text was once a panic with `--json`.
#[test]
#[cfg(unix)]
fn compare_takes_names_that_are_no_text() {
    use std::os::unix::ffi::OsStrExt;
    let workplace = Workplace::new();
    let name = std::ffi::OsStr::from_bytes(b"a\xff.pfm");
    let mut pfm = b"PF\n2 1\n-1.0\n".to_vec();
    pfm.extend([1.0_f32, 2.0, 3.0, 4.0, 5.0, 6.0].iter().flat_map(|v| v.to_le_bytes()));
    std::fs::write(workplace.path("").join(name), pfm).unwrap();
    let output = workplace.command("compare --json --html page.html").args([name, name]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(json(&String::from_utf8(output.stdout).unwrap())["images"][0]["file"], "a\u{fffd}.pfm");
}

#[test]
fn compare_writes_a_page_whatever_the_answer() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 16x12 --spp 4 --seed 5 --uniform --no-denoise -o noisy.exr --quiet");
    workplace.must("render box.obj --size 16x12 --spp 64 --uniform --no-denoise -o ref1.exr --quiet");
    workplace.must("render box.obj --size 16x12 --spp 64 --seed 1 --uniform --no-denoise -o ref2.exr --quiet");
    let table = workplace.must("compare ref1.exr noisy.exr --ref2 ref2.exr").stdout();
    let run = workplace.tamis("compare ref1.exr noisy.exr --ref2 ref2.exr --html page.html --max-rmse 1e-9");
    assert_eq!((run.code(), run.stdout()), (Some(1), table.clone()));
    let page = String::from_utf8(workplace.bytes("page.html")).unwrap();
    for name in ["high", "low"] {
        assert_eq!(page.matches(&format!("<img class=\"{name}\"")).count(), 3, "{name}");
    }
    let data = page.split("id=\"data\">").nth(1).and_then(|rest| rest.split("</script").next());
    let data = json(data.expect("the page has data"));
    let picture = |i: usize, key: &str| data["pictures"][i][key].clone();
    for (i, role, name) in
        [(0, "reference", "ref1.exr"), (1, "image", "noisy.exr"), (2, "second reference", "ref2.exr")]
    {
        assert_eq!((picture(i, "role"), picture(i, "name")), (role.into(), name.into()));
    }
    let found = picture(1, "found");
    assert_eq!((found["seed"].as_u64(), found["spp"]["mean"].as_f64()), (Some(5), Some(4.0)));
    assert_eq!(found["preset"]["name"], "best");
    for cell in data["table"]["rows"][0][1].as_array().unwrap() {
        assert!(table.contains(cell.as_str().unwrap()), "{cell} is not in:\n{table}");
    }

    workplace.must("render box.obj --size 12x16 --spp 1 --no-denoise -o turned.exr --quiet");
    for line in ["ref1.exr noisy.exr turned.exr", "ref1.exr noisy.exr --ref2 turned.exr", "ref1.exr absent.exr"] {
        let run = workplace.tamis(&format!("compare {line} --html other.html"));
        assert_eq!((run.code(), run.errors().len()), (Some(2), 1), "{line}");
    }
    let before = workplace.bytes("noisy.exr");
    for page in ["noisy.exr", "absent/page.html"] {
        let run = workplace.tamis(&format!("compare ref1.exr noisy.exr --html {page}"));
        assert!(run.code() >= Some(2) && run.errors().len() == 1 && run.stdout().is_empty(), "{page}");
    }
    assert_eq!(workplace.bytes("noisy.exr"), before);
    assert!(workplace.files().iter().all(|name| name != "other.html" && !name.starts_with(".tamis-")));
}

#[test]
fn methods_are_set_beside_each_other() {
    let workplace = Workplace::new();
    std::fs::create_dir(workplace.path("box")).unwrap();
    let files = [("b0", 2), ("b1", 2), ("b2", 2), ("b3", 2), ("ref1", 64), ("ref2", 64), ("oidn", 16)];
    for (seed, (name, spp)) in files.into_iter().enumerate() {
        let line = format!("render box.obj --size 24x24 --spp {spp} --seed {seed} --uniform --no-denoise");
        workplace.must(&format!("{line} -o box/{name}.exr --quiet"));
    }
    let tables = workplace.must("experiment methods box -o out --quiet").stdout();
    for row in ["| box | ld | ", "| box | lbf | ", "| box | paper | ", "| box | oidn | ", "(stacks: 1)"] {
        assert!(tables.contains(row), "'{row}' is not in:\n{tables}");
    }
    for name in ["methods.md", "box-paper.exr", "box-paper.png", "box-ld.exr", "box-oidn.png", "box-reference.png"] {
        assert!(workplace.path("out").join(name).exists(), "{name}");
    }
    let run = workplace.tamis("experiment methods box -o out --quiet --oidn no-such-program");
    assert_eq!((run.code(), run.errors().len()), (Some(2), 1));
    let run = workplace.tamis("compare box/ref1.exr out/box-oidn.exr --max-rmse 1e9");
    assert_eq!(run.code(), Some(0), "the pictures can be compared again");
}

#[test]
fn a_reference_is_of_the_scene_as_it_is() {
    let workplace = Workplace::new();
    let traced = || {
        let line = "experiment sequences box.obj -o out --size 12x8 --spp 1 --reference-spp 4 --set method=ld";
        workplace.must(line).stderr().contains("box: reference of 4 spp")
    };
    assert_eq!([traced(), traced()], [true, false], "it is kept");
    workplace.write("box.mtl", "newmtl white\nKd .5 .5 .5\nnewmtl red\nKd .6 .1 .1\nnewmtl lamp\nKe 12 11 9\n");
    assert_eq!([traced(), traced()], [true, false], "a scene that was edited has another");
}

#[test]
fn figures_are_made_of_scenes_and_of_buckets() {
    let workplace = Workplace::new();
    let line = "experiment figures box.obj -o out --size 20x16 --spp 4,8 --reference-spp 32 --quiet";
    let tables = workplace.must(line).stdout();
    for row in ["| box | lbf | ", "| box | nl-means | ", "| box | nfor | uniform | ", "| box | best | adaptive | 8.00"]
    {
        assert!(tables.contains(row), "'{row}' is not in:\n{tables}");
    }
    let titles = ["1", "2", "3", "4", "5", "8", "9", "10", "11"].map(|number| format!("### Figure {number}: "));
    for title in titles.iter().map(String::as_str).chain(["### Figures 6 and 7: "]) {
        assert!(tables.contains(title), "'{title}' is not in:\n{tables}");
    }
    for name in ["box-reference.png", "figure1-box-lbf-spikes.png", "figure9-box-wlr-bandwidth.png"] {
        assert!(workplace.path("out").join(name).exists(), "{name}");
    }
    std::fs::create_dir(workplace.path("buckets")).unwrap();
    for (seed, name) in ["b0", "b1", "ref1", "ref2"].into_iter().enumerate() {
        let line = format!("render box.obj --size 20x16 --spp 4 --seed {seed} --uniform --no-denoise");
        workplace.must(&format!("{line} -o buckets/{name}.exr --quiet"));
    }
    let tables = workplace.must("experiment figures buckets -o out --figures 2,7,11 --quiet").stdout();
    assert_eq!(tables.matches("###").count(), 2, "no figure 11 without a scene:\n{tables}");
    assert!(tables.contains("| buckets | wlrp | ") && tables.contains("| buckets | pixel | - | - | "), "{tables}");
}

#[test]
fn a_filter_is_trained_and_judged_and_its_weights_do_not_depend_on_threads() {
    let workplace = Workplace::new();
    std::fs::create_dir(workplace.path("scenes")).unwrap();
    let scene = "[camera]\neye = [0, 1, 3.4]\nlook_at = [0, 1, 0]\n\n[[geometry]]\nfile = \"../box.obj\"\n";
    for name in ["study", "halves", "defocus"] {
        workplace.write(&format!("scenes/{name}.toml"), scene);
    }
    let line = "experiment lbf --size 12x8 --spp 4 --reference-spp 16 --set seed=5 --quiet";
    let tables = workplace.must(&format!("{line} -o one --threads 1")).stdout();
    for row in ["| study 4 spp | ", "| defocus 4 spp | ", "| geometric mean | "] {
        assert!(tables.contains(row), "'{row}' is not in:\n{tables}");
    }
    workplace.must(&format!("{line} -o three --threads 3"));
    let weights = workplace.bytes("one/weights.txt");
    assert!(weights.starts_with(b"# Written by"));
    assert!(weights == workplace.bytes("three/weights.txt"), "the weights depend on threads");
}

#[test]
fn info_says_what_a_file_holds() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 32x32 --spp 4 -o a.exr --quiet");
    let text = workplace.must("info box.obj a.exr").stdout();
    for word in ["12 triangles", "3 materials", "32x32", "noisy", "emission", "visibility"] {
        assert!(text.contains(word), "'{word}' is not in:\n{text}");
    }
    let report = json(&workplace.must("info a.exr --json").stdout());
    assert_eq!(report[0]["size"][0].as_u64(), Some(32));
}

#[test]
fn every_guess_is_said_with_its_flag() {
    let workplace = Workplace::new();
    workplace.write("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let said = workplace.must("render plain.obj --size 16x16 --spp 1 -o a.exr -o a.png").stderr();
    for flag in ["--eye", "--env", "--exposure"] {
        assert!(said.contains(flag), "{flag} is not in:\n{said}");
    }
}

#[test]
fn buckets_of_another_renderer_are_denoised() {
    let Some(folder) = shared("stacks/buckets/pond_32") else { return };
    let workplace = Workplace::new();
    let file = |name: &str| folder.join(name).display().to_string();
    let buckets: Vec<String> = (0..8).map(|b| file(&format!("b{b}.exr"))).collect();
    workplace.must(&format!("denoise --buckets {} -o out.exr --quiet", buckets.join(" ")));
    let line = format!("compare {} out.exr {} --ref2 {} --json", file("ref1.exr"), buckets[0], file("ref2.exr"));
    let report = json(&workplace.must(&line).stdout());
    let cross = |i: usize| report["images"][i]["rmse_cross"].as_f64().unwrap();
    assert!(cross(0) < cross(1) / 8.0, "less than the noise of all eight buckets: {} against {}", cross(0), cross(1));
}

#[test]
fn two_renders_are_halves_and_what_was_found_is_reported() {
    let workplace = Workplace::new();
    for (seed, (name, spp)) in [("a", 8), ("b", 4)].into_iter().enumerate() {
        let line = format!("render box.obj --size 24x20 --spp {spp} --seed {seed} --uniform --no-denoise");
        workplace.must(&format!("{line} -o {name}.exr --quiet"));
    }
    let run =
        workplace.must("denoise --half-a a.exr --half-b b.exr -o out.exr --method ld --json --require noise,buckets");
    let report = json(&run.stdout());
    assert_eq!(report["found"]["roles"][0]["noise"], "2 buckets");
    assert_eq!(report["spp"]["mean"].as_f64(), Some(12.0));
    assert!(run.stderr().contains("found a Tamis stack: colour"), "{}", run.stderr());
    workplace.must("denoise out.exr -o again.exr --quiet");
    assert_eq!(workplace.bytes("out.exr"), workplace.bytes("again.exr"), "unequal halves are read as they were");
    let run = workplace.tamis("denoise a.exr -o c.exr --require variance");
    assert_eq!((run.code(), run.errors().len()), (Some(2), 1), "{}", run.stderr());
}

#[test]
fn many_pictures_go_on_after_a_bad_one() {
    let workplace = Workplace::new();
    for seed in 1..=2 {
        workplace.must(&format!(
            "render box.obj --size 16x16 --spp 4 --seed {seed} --no-denoise -o s.000{seed}.exr --quiet"
        ));
    }
    workplace.write("s.0003.exr", "no picture");
    let run = workplace.tamis("denoise s.####.exr -o out/clean.####.exr --method ld");
    assert_eq!((run.code(), run.errors().len()), (Some(1), 1), "{}", run.stderr());
    assert!(run.stderr().contains("1 of 3") && run.stderr().contains("s.0003.exr"), "{}", run.stderr());
    let finished = workplace.bytes("out/clean.0002.exr");
    let run = workplace.tamis("denoise s.####.exr -o out/clean.####.exr --method ld --resume");
    assert_eq!(run.stderr().matches("there already").count(), 2, "{}", run.stderr());
    assert_eq!(workplace.bytes("out/clean.0002.exr"), finished);
    workplace.must("denoise s.0001.exr s.0002.exr -o out --method ld --quiet");
    assert!(workplace.path("out/s.0001.exr").exists());
    let noisy = workplace.bytes("s.0001.exr");
    for line in ["s.0001.exr s.0002.exr -o .", "s.####.exr -o ./s.####.exr"] {
        let run = workplace.tamis(&format!("denoise {line} --aov none --method ld"));
        assert_eq!((run.code(), run.errors().len()), (Some(2), 1), "{}", run.stderr());
        assert!(run.errors()[0].contains("s.0001.exr is an input"), "{}", run.stderr());
    }
    assert!(workplace.bytes("s.0001.exr") == noisy, "inputs stay as they are");
    let run = workplace.tamis("denoise s.0001.exr s.0002.exr -o one.exr");
    assert_eq!(run.code(), Some(2));
    assert!(run.errors()[0].contains("role=FILE"), "{}", run.stderr());
}

#[test]
fn a_whole_folder_of_another_renderer_is_one_stack() {
    let Some(folder) = shared("stacks/tungsten/s256_spiky_16") else { return };
    let workplace = Workplace::new();
    let files: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path().display().to_string()).collect();
    let report = json(&workplace.must(&format!("info {} --json", files.join(" "))).stdout());
    assert_eq!(report[0]["found"]["renderer"], "Tungsten");
    assert_eq!(report[0]["features"].as_array().map(Vec::len), Some(4));
    workplace.must(&format!("denoise {} -o out.exr --method ld --quiet", files.join(" ")));
}

#[test]
fn passes_are_rebuilt_in_place_and_add_up() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 24x24 --spp 8 --quiet --uniform --no-denoise -o noisy.exr");
    let mut layers = Layers::read(&workplace.path("noisy.exr")).unwrap();
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        let noisy = layers.channels.iter().find(|channel| channel.name == format!("noisy.{name}")).unwrap();
        let part = |share: f32| FlatSamples::F32((0..576).map(|pixel| share * noisy.value(pixel)).collect());
        let passes = [("view.key", part(0.75)), ("view.sky", part(0.25 - 0.01 * c as f32))];
        let passes = passes.map(|(layer, samples)| Passthrough { name: format!("{layer}.{name}"), samples });
        layers.channels.extend(passes);
    }
    layers.write(&workplace.path("passes.exr")).unwrap();
    workplace.must("denoise passes.exr -o a.exr --aov none --also KEY,view.sky --quiet");
    // Passes need the weights of all light at once, as it was found.
    workplace.must("denoise passes.exr -o b.exr --aov none --light-apart false --light-gathered false --quiet");
    let [rebuilt, plain] = ["a.exr", "b.exr"].map(|file| Layers::read(&workplace.path(file)).unwrap());
    let at = |layers: &Layers, name: &str, pixel: usize| {
        layers.channels.iter().find(|channel| channel.name == name).unwrap().value(pixel)
    };
    assert!((0..576).all(|pixel| at(&rebuilt, "R", pixel) == at(&plain, "R", pixel)));
    let sum = |name: &str| (0..576).map(|pixel| f64::from(at(&rebuilt, name, pixel))).sum::<f64>();
    assert!((sum("view.key.R") / sum("view.sky.R") / 3.0 - 1.0).abs() < 0.05);
    let run = workplace.tamis("denoise passes.exr -o c.exr --also specular --quiet");
    assert_eq!((run.code(), run.errors().len()), (Some(2), 1));
    assert!(run.stderr().contains("view.key, view.sky"), "{}", run.stderr());
}

#[test]
fn where_nothing_is_there_is_no_light() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 24x24 --spp 4 --quiet --uniform --no-denoise -o noisy.exr");
    let mut layers = Layers::read(&workplace.path("noisy.exr")).unwrap();
    layers.metadata = None;
    layers.channels.retain(|channel| ["R", "G", "B"].contains(&&*channel.name));
    let there = |pixel: usize| if pixel % 24 < 11 { 1.0 } else { 0.0 };
    for channel in &mut layers.channels {
        let cut = (0..576).map(|pixel| there(pixel) * channel.value(pixel)).collect();
        channel.samples = FlatSamples::F32(cut);
    }
    let half = |channel: &Passthrough| FlatSamples::F32((0..576).map(|pixel| 0.5 * channel.value(pixel)).collect());
    let key = layers.channels.iter().map(|c| Passthrough { name: format!("key.{}", c.name), samples: half(c) });
    layers.channels.extend(key.collect::<Vec<_>>());
    let behind = |pixel: usize| 2.0 - 1.9 * there(pixel);
    for c in ["R", "G", "B"] {
        let samples = FlatSamples::F32((0..576).map(behind).collect());
        layers.channels.push(Passthrough { name: format!("sky.{c}"), samples });
    }
    let alpha = FlatSamples::F32((0..576).map(there).collect());
    layers.channels.push(Passthrough { name: "A".into(), samples: alpha });
    layers.write(&workplace.path("cut.exr")).unwrap();
    let run = workplace.must("denoise cut.exr -o a.exr --also key,sky");
    let kept: Vec<String> =
        run.stderr().lines().filter(|line| line.contains("keep their light")).map(String::from).collect();
    assert_eq!(kept, ["sky: 312 pixels where the picture is empty keep their light as it came"]);
    let clean = Layers::read(&workplace.path("a.exr")).unwrap();
    let plane = |name: &str| clean.channels.iter().find(|channel| channel.name == name).unwrap();
    let empty: Vec<usize> = (0..576).filter(|pixel| there(*pixel) == 0.0).collect();
    let names = ["R", "G", "B", "key.R", "key.G", "key.B"];
    assert!(names.iter().all(|name| empty.iter().all(|&pixel| plane(name).value(pixel) == 0.0)));
    assert!((0..576).map(|pixel| plane("R").value(pixel)).sum::<f32>() > 1.0);
    assert!(
        empty.iter().all(|&pixel| plane("sky.G").value(pixel) == 2.0),
        "a pass may have light where the picture has none"
    );
    let inside: Vec<f32> =
        (0..576).filter(|pixel| there(*pixel) > 0.0).map(|pixel| plane("sky.G").value(pixel)).collect();
    let mean = inside.iter().sum::<f32>() / inside.len() as f32;
    assert!((mean - 0.1).abs() < 0.03, "{mean}");
}

#[test]
fn a_guide_is_followed_where_it_is_nearer_to_the_truth() {
    let workplace = Workplace::new();
    for (file, spp, seed) in [("noisy.exr", 8, 1), ("near.exr", 512, 2), ("reference.exr", 512, 3)] {
        workplace.must(&format!(
            "render box.obj --size 40x32 --spp {spp} --seed {seed} --quiet --uniform --no-denoise -o {file}"
        ));
    }
    workplace.must("denoise noisy.exr -o alone.exr --quiet");
    let guided = |guide: &str, output: &str| {
        json(&workplace.must(&format!("denoise noisy.exr --guide {guide} -o {output} --json")).stdout())
    };
    let weight = |report: &Value| report["guide"]["mean_weight"].as_f64().unwrap();
    let (near, same) = (guided("near.exr", "near-guided.exr"), guided("alone.exr", "same.exr"));
    assert!(weight(&near) > 0.05 && (0.0..=1.0).contains(&weight(&same)), "{near} {same}");
    let line = "render box.obj --size 40x32 --spp 8 --seed 1 --uniform --guide near.exr -o at-once.exr --json";
    assert_eq!(weight(&json(&workplace.must(line).stdout())), weight(&near), "render follows it as denoise does");
    assert!(workplace.bytes("at-once.exr") == workplace.bytes("near-guided.exr"));
    let error = |file: &str| {
        let report = json(&workplace.must(&format!("compare reference.exr {file} --json")).stdout());
        report["images"][0]["rmse"].as_f64().unwrap()
    };
    assert!(error("near-guided.exr") < error("alone.exr"), "a guide that is nearly the truth helps");
    assert!((error("same.exr") / error("alone.exr") - 1.0).abs() < 1e-3, "its own picture changes nothing");
    workplace.must("render box.obj --size 20x16 --spp 1 --quiet --no-denoise -o small.exr");
    for (line, word) in [
        ("denoise noisy.exr --guide small.exr -o x.exr", "20x16"),
        ("denoise noisy.exr --guide gone.exr -o x.exr", "gone.exr"),
        ("render box.obj --size 40x32 --spp 4 --guide small.exr -o x.exr", "20x16"),
    ] {
        let run = workplace.tamis(line);
        assert_eq!((run.code(), run.errors().len(), workplace.path("x.exr").exists()), (Some(2), 1, false));
        assert!(run.stderr().contains(word), "{}", run.stderr());
    }
}

#[test]
fn bench_measures_every_step_and_sets_an_earlier_run_beside() {
    let workplace = Workplace::new();
    let bench = "bench box.obj --size 16x12 --spp 2 --rounds 1";
    let printed = workplace.must(&format!("{bench} --json")).stdout();
    let report = json(&printed);
    for step in ["copy, one thread", "closest hit, one thread", "path tracing", "best", "fast", "paper", "nfor"] {
        assert!(report["measures"][step]["rate"].as_f64().is_some_and(|rate| rate > 0.0), "{step}: {report}");
    }
    assert!(report["against"].is_null());
    // A machine that was infinitely slow, and one that was infinitely fast.
    let was = |rate: &str| format!("{{ \"measures\": {{ \"best\": {{ \"rate\": {rate} }} }} }}");
    workplace.write("slow.json", &was("1e-30"));
    workplace.write("fast.json", &was("1e30"));
    let table = workplace.must(&format!("{bench} --against fast.json")).stdout();
    assert!(table.contains("÷ earlier") && table.contains("| best | "), "{table}");
    for (file, code) in [("slow.json", 0), ("fast.json", 1)] {
        let run = workplace.tamis(&format!("{bench} --against {file} --max-loss 0.5"));
        assert_eq!(run.code(), Some(code), "{file}: {}", run.stderr());
    }
    workplace.write("printed.json", &printed);
    let run = workplace.tamis("bench box.obj --size 16x10 --spp 2 --rounds 1 --against printed.json");
    assert!(run.code() == Some(2) && run.stderr().contains("size was [16,12] then"), "{}", run.stderr());
    for wrong in
        ["--against box.obj", "--against gone.json", "--against slow.json --max-loss 1", "--max-loss 0.1", "--rounds 0"]
    {
        assert_eq!(workplace.tamis(&format!("bench --spp 1 {wrong}")).code(), Some(2), "{wrong}");
    }
}

#[test]
fn a_log_keeps_what_is_said_and_what_is_not() {
    let workplace = Workplace::new();
    let run = workplace.must("render box.obj --size 16x12 --spp 2 -o a.png --quiet --log-file log.txt");
    assert_eq!(run.stderr(), "");
    assert_eq!(workplace.tamis("render gone.obj --log-file log.txt").code(), Some(2));
    let log = String::from_utf8(workplace.bytes("log.txt")).unwrap();
    for line in
        ["render box.obj --size 16x12", "no camera given", "triangles, ", "done in ", "error: gone.obj: no such file"]
    {
        assert!(log.lines().any(|found| found.contains(" s  ") && found.contains(line)), "{line}: {log}");
    }
    assert_eq!(workplace.tamis("render box.obj --log-file no/such/folder.txt").code(), Some(3));
}

#[test]
fn checkpoints_keep_samples_until_the_picture_is_there() {
    let workplace = Workplace::new();
    let render = "render box.obj --size 16x12 --spp 8 -o a.exr";
    let run = workplace.must(&format!("{render} --checkpoint 0s --verbose"));
    assert!(run.stderr().matches("spp are kept in a.partial.exr").count() > 3, "{}", run.stderr());
    assert!(!workplace.files().contains(&"a.partial.exr".to_string()));
    let with = workplace.bytes("a.exr");
    workplace.must(render);
    assert_eq!(workplace.bytes("a.exr"), with, "the picture does not depend on it");
    let render = "render box.obj --size 16x12 --uniform --spp 21 --no-denoise";
    let run = workplace.must(&format!("{render} --checkpoint 0s --verbose -o b.exr"));
    let kept = |spp: &str| run.stderr().contains(&format!("{spp} spp are kept in b.partial.exr"));
    assert!(["8.0", "16.0", "21.0"].into_iter().all(kept), "{}", run.stderr());
    workplace.must(&format!("{render} -o c.exr"));
    assert!(workplace.bytes("b.exr") == workplace.bytes("c.exr"));
    assert!(!workplace.must(&format!("{render} --checkpoint 1h --verbose -o b.exr")).stderr().contains("are kept"));
}

#[test]
fn samples_of_an_interrupted_render_are_not_lost() {
    let workplace = Workplace::new();
    workplace.write("a.partial.exr", "many samples");
    for flags in ["", "--checkpoint 0s"] {
        let run = workplace.tamis(&format!("render box.obj --size 16x12 --spp 2 -o a.png -o a.exr {flags}"));
        assert_eq!((run.code(), run.errors().len()), (Some(2), 1), "{}", run.stderr());
        assert!(["a.partial.exr", "--resume", "delete"].iter().all(|word| run.errors()[0].contains(word)));
    }
    assert_eq!(workplace.bytes("a.partial.exr"), b"many samples");
    assert!(!workplace.path("a.exr").exists());
}

#[test]
fn a_scene_may_name_the_preset_that_its_own_settings_and_flags_override() {
    let workplace = Workplace::new();
    let render = "[render]\nspike_threshold = 3.0\npreset = \"paper\"\n";
    workplace.write("box.toml", &format!("{render}[[geometry]]\nfile = \"box.obj\"\n"));
    let report = |flags: &str| {
        json(&workplace.must(&format!("render box.toml --size 8x8 --spp 2 -o a.exr --json --quiet {flags}")).stdout())
    };
    let settings = |report: &Value| {
        let settings = &report["settings"]["reconstruction"];
        (settings["method"]["fit"].clone(), settings["spikes"]["threshold"].clone())
    };
    let paper = report("");
    assert_eq!((paper["preset"].as_str(), settings(&paper)), (Some("paper"), ("local".into(), 3.0.into())));
    let fast = report("--preset fast");
    assert_eq!((fast["preset"].as_str(), settings(&fast).1), (Some("fast"), 3.0.into()));
    assert_ne!(settings(&fast).0, "local");
}

#[test]
fn denoise_tells_what_render_tells_and_null_where_it_cannot_know() {
    let workplace = Workplace::new();
    let line = "render box.obj --size 16x12 --spp 4 --seed 5 --uniform --no-denoise -o a.exr --json --quiet";
    let rendered = json(&workplace.must(line).stdout());
    assert!(rendered["seconds"]["reconstruct"].is_null() && rendered["seconds"]["trace"].is_number());
    let ours = json(&workplace.must("denoise a.exr -o b.exr --json --quiet").stdout());
    for key in rendered.as_object().unwrap().keys() {
        let of_scenes = ["not_finite", "triangles", "textures_missing"].contains(&key.as_str());
        assert!(of_scenes || ours.get(key).is_some(), "{key}");
    }
    assert_eq!((ours["seed"].as_u64(), ours["samples"].as_u64()), (Some(5), Some(16 * 12 * 4)));
    assert!(ours["seconds"]["reconstruct"].is_number() && ours["preset"].is_null(), "{ours}");
    let mut layers = Layers::read(&workplace.path("a.exr")).unwrap();
    layers.metadata = None;
    layers.channels.retain(|channel| channel.name.contains('.') && !channel.name.starts_with("samples"));
    layers.write(&workplace.path("foreign.exr")).unwrap();
    let foreign = json(&workplace.must("denoise foreign.exr -o c.exr --preset fast --json --quiet").stdout());
    assert!(["seed", "samples", "rays", "iterations"].iter().all(|key| foreign[key].is_null()), "{foreign}");
    assert!(foreign["settings"]["trace"].is_null() && foreign["settings"]["reconstruction"].is_object());
    assert_eq!(foreign["preset"], "fast");
}

#[test]
fn compare_reads_what_render_writes() {
    let workplace = Workplace::new();
    let outputs = "-o a.exr -o a.png -o a.hdr -o a.pfm --exposure 0";
    workplace.must(&format!("render box.obj --size 24x16 --spp 4 --uniform --no-denoise {outputs} --quiet"));
    let report = json(&workplace.must("compare a.exr a.png a.hdr a.pfm --json").stdout());
    let flip = |i: usize| report["images"][i]["flip"].as_f64().unwrap();
    assert!(flip(0) < 0.01 && flip(1) < 0.03 && flip(2) == 0.0, "{report}");
    let run = workplace.tamis("info a.png");
    let said = run.stderr();
    assert!(run.code() == Some(2) && said.contains(".obj") && said.contains(".exr"), "{said}");
}

#[test]
fn inputs_may_come_through_pipes() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 16x12 --spp 4 --uniform --no-denoise -o a.exr --quiet");
    workplace.must("denoise a.exr -o b.exr --method ld --quiet");
    let piped = |line: &str, bytes: &[u8]| {
        let mut command = workplace.command(line);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(bytes).unwrap();
        child.wait_with_output().unwrap()
    };
    let through_pipe = |line: &str| {
        let output = piped(line, &workplace.bytes("a.exr"));
        assert!(output.status.success(), "{line}");
        String::from_utf8(output.stdout).unwrap()
    };
    through_pipe("denoise - -o c.exr --method ld --quiet");
    assert!(workplace.bytes("c.exr") == workplace.bytes("b.exr"));
    #[cfg(target_os = "linux")]
    through_pipe("denoise /dev/stdin -o d.exr --method ld --quiet");
    assert_eq!(json(&through_pipe("info - --json"))[0]["file"], "-");
    let report = json(&through_pipe("compare a.exr - --json"));
    assert_eq!((&report["images"][0]["file"], report["images"][0]["rmse"].as_f64()), (&"-".into(), Some(0.0)));
    assert_eq!(json(&through_pipe("compare a.exr b.exr --mask - --json"))["mask"], "-");
    let guided = json(&through_pipe("denoise a.exr --guide - -o e.exr --json"));
    assert_eq!(guided["guide"]["file"], "-");
    workplace.must("render box.obj --size 16x12 --samples 0..2 --no-denoise -o s.exr --quiet");
    workplace.must("render box.obj --size 16x12 --samples 2..4 --no-denoise -o t.exr --quiet");
    let merged = piped("merge - t.exr -o m.exr --quiet", &workplace.bytes("s.exr"));
    assert!(merged.status.success(), "{}", String::from_utf8_lossy(&merged.stderr));
    workplace.must("merge s.exr t.exr -o n.exr --quiet");
    assert!(workplace.bytes("m.exr") == workplace.bytes("n.exr"));
    let run = workplace.tamis("denoise a.exr -o -");
    assert!(run.code() == Some(2) && run.stderr().contains("standard output"), "{}", run.stderr());
    // Copies of pipes are nobody's business.
    for line in [
        "denoise - -o o.exr",
        "denoise a.exr --guide - -o o.exr",
        "info -",
        "merge - a.exr -o o.exr",
        "compare a.exr -",
    ] {
        let output = piped(line, b"no picture");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && said.contains("standard input: not a readable"), "{line}: {said}");
    }
    let output = piped("denoise - -o folder/", &workplace.bytes("a.exr"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && said.contains("standard input has no name"), "{said}");
    let run = workplace.tamis("denoise a.exr -o o.exr --max-memory 1.5m");
    assert!(run.code() == Some(2) && run.stderr().contains("--max-memory 1.5m: "), "{}", run.stderr());
}

#[test]
fn layers_that_were_chosen_and_are_not_made_are_named() {
    let workplace = Workplace::new();
    let said =
        |flags: &str| workplace.must(&format!("render box.obj --size 8x8 --spp 2 --uniform -o a.exr {flags}")).stderr();
    let text = said("--aov mse,bandwidth,rank");
    assert!(text.contains("no layer bandwidth, rank: this method"), "{text}");
    let text = said("--no-denoise --aov mse");
    assert!(text.contains("no layer mse: nothing was reconstructed"), "{text}");
    for flags in ["--no-denoise", "--aov all", "--preset paper --aov rank"] {
        assert!(!said(flags).contains("no layer"), "{flags}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_standard_error_that_takes_nothing_costs_no_picture() {
    let workplace = Workplace::new();
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let line = "render box.obj --size 8x8 --spp 1 --no-denoise -o a.exr";
    assert!(workplace.command(line).stderr(full).status().unwrap().success());
    assert!(workplace.path("a.exr").exists());
}
