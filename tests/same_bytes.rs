//! Same seed, same bytes; and what was written can be reconstructed again.

mod support;

use stack::file::{Layers, read_picture};
use support::Workplace;

const RENDER: &str = "render box.obj --size 48x40 --spp 12 --quiet --aov all";

#[test]
fn the_thread_count_does_not_matter() {
    let workplace = Workplace::new();
    for threads in [1, 2, 7] {
        workplace.must(&format!("{RENDER} --threads {threads} -o {threads}.exr -o {threads}.png"));
    }
    for ending in ["exr", "png"] {
        let one = workplace.bytes(&format!("1.{ending}"));
        assert!(one == workplace.bytes(&format!("2.{ending}")) && one == workplace.bytes(&format!("7.{ending}")));
    }
}

#[test]
fn another_seed_gives_another_picture() {
    let workplace = Workplace::new();
    workplace.must(&format!("{RENDER} -o a.exr"));
    workplace.must(&format!("{RENDER} --seed 7 -o b.exr"));
    assert_ne!(read_picture(&workplace.path("a.exr")).unwrap(), read_picture(&workplace.path("b.exr")).unwrap());
}

#[test]
fn denoise_repeats_render_bit_for_bit() {
    let workplace = Workplace::new();
    for flags in ["--preset best", "--preset paper --spike-threshold 1.5", "--method ld"] {
        workplace.must(&format!("{RENDER} {flags} -o a.exr"));
        workplace.must("denoise a.exr -o b.exr --aov all --quiet");
        assert_eq!(workplace.bytes("a.exr"), workplace.bytes("b.exr"), "{flags}");
    }
}

#[test]
fn less_memory_makes_the_same_file_or_is_refused() {
    let workplace = Workplace::new();
    let flags = "--size 48x200 --spp 8 --buckets 2 --sequences 2 --quiet --uniform --no-denoise";
    workplace.must(&format!("render box.obj {flags} -o noisy.exr"));
    workplace.must("denoise noisy.exr -o a.exr --quiet");
    // The second pass is made in bands.
    workplace.must("denoise noisy.exr -o b.exr --quiet --max-memory 66556000");
    assert!(workplace.bytes("a.exr") == workplace.bytes("b.exr"));
}

#[test]
fn a_limit_that_cannot_be_kept_is_refused_before_pixels_are_read_and_the_one_that_is_named_will_do() {
    let workplace = Workplace::new();
    for seed in 0..3 {
        let flags = format!("--size 48x200 --spp 2 --uniform --seed {seed} --quiet --no-denoise");
        workplace.must(&format!("render box.obj {flags} -o b{seed}.exr"));
    }
    let whole = workplace.bytes("b1.exr");
    let mut without_pixels = whole.clone();
    let pixels = without_pixels.len() / 4;
    without_pixels[pixels..].fill(0);
    std::fs::write(workplace.path("b1.exr"), &without_pixels).unwrap();
    let denoise = "denoise --buckets b0.exr b1.exr b2.exr -o c.exr --quiet --max-memory";
    let run = workplace.tamis(&format!("{denoise} 10M"));
    assert_eq!((run.code(), run.errors().len(), workplace.path("c.exr").exists()), (Some(2), 1, false));
    let error = &run.errors()[0];
    let least = error.split_whitespace().find(|word| word.ends_with('M')).unwrap_or_else(|| panic!("{error}"));
    let run = workplace.tamis(&format!("{denoise} {least}"));
    assert!(run.code() == Some(2) && run.errors()[0].contains("b1.exr"), "the pixels are read next: {}", run.stderr());
    std::fs::write(workplace.path("b1.exr"), whole).unwrap();
    workplace.must(&format!("{denoise} {least}"));
    let less = least.trim_end_matches('M').parse::<u32>().unwrap() - 1;
    assert_eq!(workplace.tamis(&format!("{denoise} {less}M")).code(), Some(2));
}

#[test]
fn result_layers_of_the_input_are_never_read() {
    let workplace = Workplace::new();
    workplace.must(&format!("{RENDER} --preset paper -o a.exr"));
    let mut layers = Layers::read(&workplace.path("a.exr")).unwrap();
    let mut overwritten = 0;
    for channel in &mut layers.channels {
        let result = ["R", "G", "B"].contains(&channel.name.as_str())
            || ["mse.", "spikes.", "bandwidth.", "rank."].iter().any(|layer| channel.name.starts_with(layer));
        if let (true, exr::prelude::FlatSamples::F32(values)) = (result, &mut channel.samples) {
            overwritten += 1;
            values.iter_mut().enumerate().for_each(|(i, value)| *value = ((i * 7919) % 101) as f32);
        }
    }
    assert_eq!(overwritten, 9);
    layers.write(&workplace.path("scribbled.exr")).unwrap();
    workplace.must("denoise scribbled.exr -o b.exr --aov all --quiet");
    assert_eq!(workplace.bytes("a.exr"), workplace.bytes("b.exr"));
}

#[test]
fn renders_of_ours_serve_as_buckets_and_what_was_written_is_read_again() {
    let workplace = Workplace::new();
    for seed in 0..3 {
        workplace.must(&format!("render box.obj --size 24x20 --spp 4 --uniform --seed {seed} -o b{seed}.exr --quiet"));
    }
    workplace.must("denoise --buckets b0.exr b1.exr b2.exr -o a.exr --aov all --quiet");
    workplace.must("denoise a.exr -o b.exr --aov all --quiet");
    assert_eq!(workplace.bytes("a.exr"), workplace.bytes("b.exr"));
}

#[test]
fn a_file_says_which_settings_it_was_made_with() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 24x20 --spp 4 --spike-threshold 3 -o a.exr --quiet");
    workplace.must("denoise a.exr -o b.exr --window-radius 4 --quiet");
    workplace.must("denoise b.exr -o c.exr --preset paper --quiet");
    let said = ["b.exr", "c.exr"].map(|file| workplace.must(&format!("info {file}")).stdout());
    let (threshold, radius) = ("spikes.threshold: 3.0, by default 2.5", "window.radius: 4, by default 11");
    assert!(said[0].contains(threshold) && said[0].contains(radius), "{}", said[0]);
    assert!(said[1].contains("method.fit: local, by default") && !said[1].contains("threshold"), "{}", said[1]);
    assert!(said.iter().all(|said| said.contains("per pixel 4\n") && !said.contains('{')), "{said:?}");
    let mut layers = Layers::read(&workplace.path("a.exr")).unwrap();
    layers.metadata.as_mut().unwrap()["settings"]["reconstruction"]["spikes"]["threshold"] = (-1.0).into();
    layers.write(&workplace.path("d.exr")).unwrap();
    let run = workplace.must("denoise d.exr -o e.exr");
    assert!(
        run.stderr().contains("not used, but those of --preset best: --spike-threshold: -1 is"),
        "{}",
        run.stderr()
    );
    assert!(!workplace.must("denoise d.exr -o e.exr --preset paper").stderr().contains("--spike-threshold"));
}

#[test]
fn how_samples_were_taken_is_not_rewritten_when_they_are_denoised() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 16x12 --spp 4 --seed 7 --max-depth 5 --initial-spp 3 -o a.exr --quiet");
    workplace.must("denoise a.exr -o b.exr --preset paper --quiet");
    let settings = |file: &str| Layers::read(&workplace.path(file)).unwrap().metadata.unwrap()["settings"].clone();
    let (before, after) = (settings("a.exr"), settings("b.exr"));
    for group in ["trace", "rounds", "sampling"] {
        assert!(!before[group].is_null() && before[group] == after[group], "{group}: {after}");
    }
    assert_eq!(after["reconstruction"]["method"]["fit"], "local");
    workplace.must("denoise b.exr -o c.exr --quiet");
    assert!(workplace.bytes("b.exr") == workplace.bytes("c.exr"), "it is rebuilt as it says it was");
    for flag in ["--max-depth 3", "--seed 9", "--iterations 2"] {
        let run = workplace.tamis(&format!("denoise a.exr {flag} -o d.exr"));
        let said = run.stderr();
        assert!(run.code() == Some(2) && said.contains("only render takes samples"), "{said}");
    }
}

#[test]
fn a_crop_shows_the_same_noise_as_the_whole() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 48x40 --spp 4 --uniform --no-denoise --quiet -o whole.exr");
    workplace.must("render box.obj --size 48x40 --crop 8,4,20,10 --spp 4 --uniform --no-denoise --quiet -o crop.exr");
    let [whole, crop] = ["whole", "crop"].map(|n| read_picture(&workplace.path(&format!("{n}.exr"))).unwrap());
    for y in 0..10 {
        for x in 0..20 {
            assert_eq!(crop.rgb(crop.size().index(x, y)), whole.rgb(whole.size().index(x + 8, y + 4)));
        }
    }
}
