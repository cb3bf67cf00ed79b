use std::path::PathBuf;

use base64::Engine;
use reconstruct::metrics::compare;
use stack::Size;

use super::super::encoded_picture::tests::decode;
use super::*;

const SIZE: Size = Size::new(7, 5);

fn picture(k: usize) -> Image {
    let value = |i: usize, c: usize| ((i * 37 + c * 11 + k * 5) % 101) as f32 / 40.0 + 0.01;
    Image::from_channels(SIZE, (0..3).map(|c| (0..SIZE.pixels()).map(|i| value(i, c)).collect()).collect())
}

fn args(images: &[&str]) -> CompareArgs {
    CompareArgs {
        reference: PathBuf::from("ref.exr"),
        images: images.iter().map(PathBuf::from).collect(),
        ref2: None,
        epsilon: 0.001,
        max_rmse: None,
        max_flip: None,
        mask: None,
        html: None,
        json: false,
    }
}

/// The page of a reference and pictures of these names, and the pictures.
fn page_of(names: &[&str], mask: Option<&[bool]>, record: &Record) -> (String, Vec<Image>, Scale) {
    let pictures: Vec<Image> = (0..=names.len()).map(picture).collect();
    let args = args(names);
    let reference = Reference { mask, ..Reference::new(&pictures[0]) };
    let scale = Scale::of(&pictures[0]);
    let show = |file: &Path, picture: &Image| Shown::new(file, picture, record, scale).unwrap();
    let first = show(&args.reference, &pictures[0]);
    let shown: Vec<Shown> = args.images.iter().zip(&pictures[1..]).map(|(file, p)| show(file, p)).collect();
    let measured: Vec<_> = args.images.iter().zip(&pictures[1..]).collect();
    let measured: Vec<_> =
        measured.iter().map(|(file, picture)| (file.as_path(), compare(picture, &reference).unwrap())).collect();
    let table = MeasureTable::of(&measured);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("page.html");
    Page { args: &args, reference, scale, first, shown, second: None, table }.write(&file).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no litter");
    (std::fs::read_to_string(&file).unwrap(), pictures, scale)
}

/// The bytes of all embedded pictures of a class, in order.
fn embedded(page: &str, class: &str) -> Vec<Vec<u8>> {
    let start = format!("<img class=\"{class}\" alt=\"\" src=\"data:image/png;base64,");
    page.split(&start).skip(1).map(|rest| STANDARD.decode(rest.split('"').next().unwrap()).unwrap()).collect()
}

/// What the scripts read, as a browser finds it: up to the first end of a script.
fn data(page: &str) -> Value {
    let rest = page.split("<script type=\"application/json\" id=\"data\">").nth(1).unwrap();
    serde_json::from_str(rest.split("</script").next().unwrap()).unwrap()
}

/// The page without the bytes of its pictures, in which any word may stand by chance.
fn text(page: &str) -> String {
    let mut parts = page.split("base64,");
    let first = parts.next().unwrap().to_string();
    parts.fold(first, |text, part| text + part.split_once('"').unwrap().1)
}

#[test]
fn every_picture_is_there_once_and_as_it_is() {
    let (page, pictures, scale) = page_of(&["a.exr", "b.exr"], None, &Record::default());
    let (high, low) = (embedded(&page, "high"), embedded(&page, "low"));
    assert_eq!((high.len(), low.len(), page.matches("base64,").count()), (3, 3, 7));
    for ((high, low), picture) in high.iter().zip(&low).zip(&pictures) {
        let found = decode(high, low, scale.coding);
        for (found, expected) in found.channels().iter().flatten().zip(picture.channels().iter().flatten()) {
            assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
        }
    }
    let data = data(&page);
    let named = |i: usize| (data["pictures"][i]["role"].clone(), data["pictures"][i]["name"].clone());
    assert_eq!(named(0), (json!("reference"), json!("ref.exr")));
    assert_eq!(named(2), (json!("image"), json!("b.exr")));
    assert_eq!(data["pictures"].as_array().map(Vec::len), Some(3));
    assert_eq!((&data["size"], &data["factor"], &data["leftOut"]), (&json!([7, 5]), &json!(1), &json!(0)));
    assert_eq!(data["stops"].as_f64().unwrap() as f32, crate::exposure::choose(&pictures[0]));
    assert_eq!(data["epsilon"].to_string(), "0.001");
}

#[test]
fn the_page_has_the_numbers_of_the_table() {
    let (page, pictures, _) = page_of(&["a.exr", "b.exr"], None, &Record::default());
    let measured = [("a.exr", 1), ("b.exr", 2)]
        .map(|(name, i)| (Path::new(name), compare(&pictures[i], &Reference::new(&pictures[0])).unwrap()));
    assert_eq!(data(&page)["table"], json!(MeasureTable::of(&measured)));
}

#[test]
fn the_page_says_the_settings_of_every_file() {
    let settings = json!({"trace": {"seed": 11, "max-depth": 5}});
    let record = Record { settings: Some(settings), software: Some("tamis".into()), spp: None };
    let (page, ..) = page_of(&["a.exr"], None, &record);
    for picture in data(&page)["pictures"].as_array().unwrap() {
        let found = &picture["found"];
        assert_eq!((&found["seed"], &found["software"], &found["spp"]), (&json!(11), &json!("tamis"), &Value::Null));
        assert_eq!(found["settings"], json!({"trace.seed": 11, "trace.max-depth": 5}));
    }
}

#[test]
fn names_and_settings_cannot_break_out() {
    let hostile = ["</script><script>alert(1)</script>.exr", "<!--<script>.exr", "{{pictures}}\"'&\u{2028}.exr"];
    let settings = json!({"</script><img src=x onerror=alert(1)>": "</style><!--"});
    let record = Record { settings: Some(settings.clone()), ..Record::default() };
    let (plain, ..) = page_of(&["a.exr", "b.exr", "c.exr"], None, &Record::default());
    let (page, ..) = page_of(&hostile, None, &record);
    let tags = |page: &str| ["<script", "</script", "<!--", "<img", "</style"].map(|tag| page.matches(tag).count());
    assert_eq!(tags(&page), tags(&plain));
    let data = data(&page);
    for (i, name) in hostile.iter().enumerate() {
        assert_eq!(data["pictures"][i + 1]["name"], **name);
        assert_eq!(data["table"]["rows"][i][0], **name);
    }
    assert_eq!(data["pictures"][0]["found"]["settings"], settings);
    for unsafe_way in ["innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "Function("] {
        assert!(SCRIPTS.iter().all(|script| !script.contains(unsafe_way)), "{unsafe_way}");
    }
}

#[test]
fn the_page_needs_no_other_file() {
    let (page, ..) = page_of(&["a.exr"], None, &Record::default());
    let text = text(&page);
    for outside in ["http", "//cdn", "src=\"/", "href", "@import", "url(", "import ", "fetch(", "{{", "}}\n"] {
        assert!(!text.contains(outside), "{outside}");
    }
    assert_eq!(text.matches("src=").count(), text.matches("src=\"data:image/png;").count());
}

#[test]
fn the_page_has_all_its_parts() {
    let (page, ..) = page_of(&["a.exr"], None, &Record::default());
    let ids = |text: &str, start: &str, end: char| -> Vec<String> {
        text.split(start).skip(1).filter_map(|rest| Some(rest.split_once(end)?.0.to_string())).collect()
    };
    let there = ids(FRAME, "id=\"", '"');
    let wanted: Vec<String> = SCRIPTS.iter().flat_map(|script| ids(script, "at(\"", '"')).collect();
    assert!(wanted.len() > 40);
    for id in wanted.iter().map(String::as_str).chain([
        "slider",
        "grid",
        "exposure",
        "legend",
        "insets",
        "histogram",
        "measures",
        "found",
        "all-settings",
    ]) {
        assert!(there.iter().any(|name| name == id), "{id}");
    }
    let unique: std::collections::HashSet<&String> = there.iter().collect();
    assert_eq!(unique.len(), there.len());
    for part in std::iter::once(STYLE).chain(SCRIPTS) {
        assert_eq!(page.matches(part).count(), 1);
    }
}

#[test]
fn pixels_that_are_not_judged_are_marked() {
    let mask: Vec<bool> = (0..SIZE.pixels()).map(|i| i % 4 != 0).collect();
    let (page, ..) = page_of(&["a.exr"], Some(&mask), &Record::default());
    let judged = image::load_from_memory(&embedded(&page, "judged")[0]).unwrap().into_luma8();
    assert_eq!(judged.iter().map(|byte| *byte == 255).collect::<Vec<_>>(), mask);
    assert_eq!(data(&page)["leftOut"], 9);
}

#[test]
fn only_pages_may_be_replaced() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.exr", "page", "page.html/x.html"] {
        assert!(check_page(&folder.path().join(name)).is_err(), "{name}");
    }
    for name in ["page.html", "PAGE.HTM"] {
        check_page(&folder.path().join(name)).unwrap();
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
