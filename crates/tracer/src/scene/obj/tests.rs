use std::fs;
use std::path::Path;

use glam::{Vec3, Vec4};
use tempfile::TempDir;

use super::super::notes::Notes;
use super::{ObjFile, assemble, cut, parse, read_obj};
use crate::material::{Surface, Tinted};
use crate::scene::mtl::MtlLibrary;

/// A folder with an OBJ file and perhaps other files.
fn folder(obj: &[u8], others: &[(&str, &[u8])]) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("a.obj"), obj).unwrap();
    for (name, content) in others {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }
    folder
}

fn read(obj: &[u8], others: &[(&str, &[u8])]) -> (ObjFile, Vec<String>) {
    let folder = folder(obj, others);
    let mut notes = Notes::default();
    let file = read_obj(&folder.path().join("a.obj"), &mut notes).unwrap();
    (file, notes.into_lines())
}

fn refusal(obj: &[u8]) -> String {
    let folder = folder(obj, &[]);
    let error = read_obj(&folder.path().join("a.obj"), &mut Notes::default()).unwrap_err();
    error.to_string().replace(&format!("{}/", folder.path().display()), "")
}

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn with_corners(rest: &str) -> Vec<u8> {
    format!("{CORNERS}{rest}").into_bytes()
}

#[test]
fn quads_and_negative_indices_make_triangles() {
    let (file, notes) = read(&with_corners("f -4 -3 -2 -1\nf 1 2 3\n"), &[]);
    let corners = |t: usize| file.mesh.triangles[t].map(|v| file.mesh.positions[v as usize]);
    assert_eq!(corners(0), [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)]);
    assert_eq!(corners(1), [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    assert_eq!(corners(2), corners(0));
    assert!(notes.is_empty());
}

#[test]
fn mistakes_are_told_with_their_line() {
    assert_eq!(refusal(b""), "a.obj: the file is empty, expected vertices and faces");
    assert_eq!(refusal(CORNERS.as_bytes()), "a.obj: has 4 vertices but no face with three corners");
    assert_eq!(refusal(&with_corners("f 1 2\nl 1 2\np 1\n")), "a.obj: has 4 vertices but no face with three corners");
    assert_eq!(refusal(b"# x\nv 0 0 zero\n"), "a.obj:2: expected v and three numbers, found 'v 0 0 zero'");
    assert_eq!(
        refusal(b"v +1 2. .5\nv 1E+2 2.e-1 -3e01\nv 1 2 3.1+e2\n"),
        "a.obj:3: expected v and three numbers, found 'v 1 2 3.1+e2'"
    );
    assert_eq!(refusal(b"v 0 0\n"), "a.obj:1: expected v and three numbers, found 'v 0 0'");
    assert_eq!(
        refusal(&with_corners("f 1 2 3\nf 1 2 5\nf 1 2 7\n")),
        "a.obj:6: expected a vertex that exists (there are 4), found number 5"
    );
    assert_eq!(
        refusal(&with_corners("f 1 2 0\n")),
        "a.obj:5: expected a vertex that exists (there are 4), found number 0"
    );
    assert_eq!(
        refusal(&with_corners("f 1 2 -5\n")),
        "a.obj:5: expected a vertex that exists (there are 4), found number -5"
    );
    assert_eq!(
        refusal(&with_corners("vt 0 0\nf 1/1 2/2 3/1\n")),
        "a.obj:6: expected a texture coordinate that exists (there are 1), found number 2"
    );
    assert_eq!(refusal(&with_corners("f 1 b 3\n")), "a.obj:5: expected corners like 1, 1/2, 1//3 or 1/2/3, found 'b'");
}

#[test]
fn pieces_of_any_size_make_the_same_mesh_and_the_same_mistakes() {
    let mixed = "v 0 0 0\nvt 0 0\n# v\r\nv 1 0 0\nvn 0 0 1\nf 1 2 3\nv 1 1 0\nv 0 1 0\rvt 1 0\nusemtl a\n\
        f -4/-2/-1 -3/1/1 \\\n  -2/2/1 4/2/1\nf 1/1 2/2 3/1\nusemtl b\nf 1//1 2//1 4//1\nf 1 2\nv 2 .5 0\nf -1 -2 -3 -4\n\
        f 2/1/1 4/1/1 5/1/1\np 1\n";
    let mesh = |size: usize| {
        let (path, mut notes) = (Path::new("a.obj"), Notes::default());
        let pieces = parse(mixed, size, path).unwrap();
        let mesh = assemble(pieces, &mut MtlLibrary::new("".into()), path, &mut notes);
        (format!("{mesh:?}"), notes.into_lines())
    };
    let whole = mesh(usize::MAX);
    assert_eq!(cut(mixed, 1).len(), mixed.matches('\n').count() - 1, "the continued line is not cut");
    for size in 0..mixed.len() {
        assert_eq!(cut(mixed, size).concat(), mixed);
        assert_eq!(mesh(size), whole);
    }
    for (wrong, expected) in [
        ("v 1\n", "a.obj:21: expected v and three numbers, found 'v 1'"),
        ("f 1 2 6\n", "a.obj:21: expected a vertex that exists (there are 5), found number 6"),
        ("f 1 2 4294967296\n", "a.obj:21: expected a vertex that exists (there are 5), found number 4294967296"),
        ("f -6 2 1\n", "a.obj:21: expected a vertex that exists (there are 5), found number -6"),
    ] {
        for size in [1, 40, 1000] {
            let error = parse(&format!("{mixed}{wrong}# end\n"), size, Path::new("a.obj")).unwrap_err();
            assert_eq!(error.to_string(), expected, "{size}");
        }
    }
}

#[test]
fn missing_files_and_folders_are_told_apart() {
    let folder = folder(b"", &[]);
    let refuse = |path: &Path| read_obj(path, &mut Notes::default()).unwrap_err().to_string();
    assert!(refuse(&folder.path().join("b.obj")).contains("no such file"));
    assert!(refuse(folder.path()).contains("is a folder"));
}

#[test]
fn what_other_programs_write_is_understood() {
    let obj = b"# caf\xe9\r\nmtllib\tnone.mtl\r\nusemtl \r\nv 0 0 0 # origin\r\nv 1 \\\r\n 0 0\r\nv 0 1 0\r\nv 1.#QNAN 0 0\r\n\
        v -nan(ind) 0 0\r\nvt 0.5\r\ng \xff\r\nf 1 2 3\r\nf 1 2 4\r\nf 1/1 2/1 3/1\r\nf 1/1 2 3/1\r\nf 1\r\n";
    let (file, notes) = read(obj, &[]);
    assert_eq!(file.mesh.triangles.len(), 4);
    assert_eq!(file.mesh.positions[1], Vec3::X);
    let bad = file.mesh.triangles[1].map(|v| file.mesh.positions[v as usize]);
    assert!(bad[2].x.is_nan());
    assert_eq!(file.mesh.uvs.len(), file.mesh.positions.len());
    let uv = |t: usize| file.mesh.uvs[file.mesh.triangles[t][0] as usize].x;
    assert_eq!([uv(0), uv(2), uv(3)], [0.0, 0.5, 0.0]);
    assert_eq!(notes.len(), 2, "{notes:?}");
}

#[test]
fn normals_that_the_file_has_none_of_are_done_without() {
    let (file, notes) = read(&with_corners("vt 0 0\nf 1/1/1 2/1/2 3/1/9\nf 1//1 2//1 3//1\n"), &[]);
    assert_eq!((file.mesh.triangles.len(), file.mesh.normals.len()), (2, 0));
    assert!(notes[0].ends_with("a.obj: faces refer to normals, of which the file has none; they do without"));
    let (file, notes) = read(&with_corners("f 1/1 2/1 3/1\n"), &[]);
    assert_eq!((file.mesh.triangles.len(), notes.len()), (1, 1));
}

#[test]
fn some_vertices_may_have_colours() {
    let (file, notes) = read(b"v 0 0 0 1 0.5 0\nv 2 0 0\nv 0 4 0 2\nf 1 2 3\n", &[]);
    assert_eq!((file.mesh.positions[2].y, notes.len()), (2.0, 0), "the fourth of four numbers is a divisor");
    let half = ((0.5 + 0.055) / 1.055_f32).powf(2.4);
    assert_eq!(file.mesh.colours, [Vec4::new(1.0, half, 0.0, 1.0), Vec4::ONE, Vec4::ONE]);
    let white = |file: &ObjFile| matches!(&file.materials[0].surface, Surface::Diffuse { reflectance } if reflectance.factor == Vec3::ONE);
    assert!(white(&file), "there is no grey to multiply a colour with");
    // With normals, corners are no positions; and of 255.
    let (file, _) = read(b"v 0 0 0 255 0 0\nv 2 0 0 0 51 0\nv 0 4 0 0 0 255\nvn 0 0 1\nf 2//1 3//1 1//1\n", &[]);
    let fifth = ((0.2 + 0.055) / 1.055_f32).powf(2.4);
    assert!((file.mesh.colours[0] - Vec4::new(0.0, fifth, 0.0, 1.0)).length() < 1e-6);
    assert_eq!(file.mesh.colours[1..], [Vec4::new(0.0, 0.0, 1.0, 1.0), Vec4::new(1.0, 0.0, 0.0, 1.0)]);
    let (file, _) = read(b"v 0 0 0 1 1 1\nv 2 0 0 1 1 1\nv 0 4 0 1 1 1\nf 1 2 3\n", &[]);
    assert!(file.mesh.colours.is_empty() && !white(&file), "all white is what programs write that know no colours");
}

#[test]
fn a_texture_takes_the_place_of_colours_of_vertices() {
    let obj = b"mtllib a.mtl\nv 0 0 0 1 0 0\nv 2 0 0\nv 0 4 0\nusemtl a\nf 1 2 3\n";
    let tinted = |library: &str| {
        let mut picture = std::io::Cursor::new(vec![]);
        image::RgbImage::new(1, 1).write_to(&mut picture, image::ImageFormat::Png).unwrap();
        let (file, _) = read(obj, &[("a.mtl", library.as_bytes()), ("a.png", picture.get_ref())]);
        file.materials[0].maps.tinted
    };
    assert_eq!(tinted("newmtl a\nKd .5 .5 .5\n"), Tinted::Base);
    assert_eq!(tinted("newmtl a\nmap_Kd gone.png\n"), Tinted::Base);
    assert_eq!(tinted("newmtl a\nmap_Kd a.png\n"), Tinted::Nothing);
}

#[test]
fn utf_16_is_read() {
    let obj: Vec<u8> = with_corners("f 1 2 3").iter().flat_map(|&b| [b, 0]).collect();
    let (file, _) = read(&[&[0xff, 0xfe], obj.as_slice()].concat(), &[]);
    assert_eq!(file.mesh.triangles.len(), 1);
}

#[test]
fn materials_come_from_libraries_by_name() {
    let obj = with_corners(
        "mtllib my lib.mtl\nmtllib b.mtl c.mtl\nusemtl 7\nf 1 2 3\nusemtl lamp one\nf 1 2 4\nusemtl ?\nf 2 3 4\n",
    );
    let libraries: [(&str, &[u8]); 2] = [
        ("my lib.mtl", b"newmtl 7\nKd 1 0 0\nNs 3200 grey wall\n"),
        ("B.MTL", b"\tnewmtl lamp one \r\n\tKe 1 2 3\r\n"),
    ];
    let (file, notes) = read(&obj, &libraries);
    let of = |t: usize| &file.materials[file.mesh.materials[t] as usize];
    assert_eq!([of(0), of(1), of(2)].map(|m| m.name.as_str()), ["7", "lamp one", "default"]);
    assert_eq!(of(1).emission.factor, Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(notes.len(), 2);
    assert!(notes.iter().any(|n| n.contains("no library has material '?'")));
    assert!(notes.iter().any(|n| n.contains("'c.mtl' is missing")));
}

#[test]
fn names_may_hold_signs_of_comments_and_libraries_may_come_late_or_twice() {
    let obj = with_corners(
        "usemtl late\nf 1 2 3\nmtllib m #1.mtl\n# C:\\\nusemtl Material #25\nf 1 2 3\nusemtl late # the wall\nf 1 2 3\n\
            mtllib m #1.mtl\nusemtl #\nf 1 2 3\nusemtl none # here\nf 1 2 3\n",
    );
    let library: (&str, &[u8]) = ("m #1.mtl", b"newmtl Material #25\nnewmtl late\n");
    let (file, notes) = read(&obj, &[library]);
    let names = file.mesh.materials.iter().map(|&m| file.materials[m as usize].name.as_str());
    assert_eq!(names.collect::<Vec<_>>(), ["late", "Material #25", "late", "late", "default"]);
    assert_eq!((file.materials.len(), notes.len()), (3, 1), "read once: {notes:?}");
    assert!(notes[0].contains("no library has material 'none'"));
}

#[test]
fn textures_are_found_ignoring_case_and_backslashes_and_missed_with_a_note() {
    let image = image::RgbImage::from_pixel(1, 1, image::Rgb([255, 0, 0]));
    let mut png = std::io::Cursor::new(vec![]);
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let mtl = b"newmtl a\nKd 1 1 1\nmap_Kd -s 2 1 1 Tex\\RED.png\nnewmtl b\nKd 0 1 0\nmap_Kd gone.png\nnewmtl c\nmap_Kd a.obj\n";
    let obj = with_corners("mtllib m.mtl\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n");
    let (file, notes) = read(&obj, &[("m.mtl", mtl), ("tex/red.png", png.get_ref())]);
    let Surface::Diffuse { reflectance } = &file.materials[0].surface else { panic!("not diffuse") };
    let texture = reflectance.texture.as_ref().unwrap();
    assert_eq!(texture.texels[0], [1.0, 0.0, 0.0]);
    assert_eq!(texture.map, glam::Mat2::from_diagonal(glam::Vec2::new(2.0, 1.0)));
    let Surface::Diffuse { reflectance } = &file.materials[1].surface else { panic!("not diffuse") };
    assert!(reflectance.texture.is_none() && reflectance.factor == Vec3::Y);
    assert_eq!(notes.len(), 2);
    assert!(notes[0].contains("'gone.png' is missing") && notes[1].contains("cannot be read"));
}

/// A PNG file of one row.
fn png(image: impl Into<image::DynamicImage>) -> Vec<u8> {
    let mut file = std::io::Cursor::new(vec![]);
    image.into().write_to(&mut file, image::ImageFormat::Png).unwrap();
    file.into_inner()
}

#[test]
fn maps_make_holes_relief_roughness_and_metal() {
    let leaf = image::RgbaImage::from_raw(2, 1, vec![255, 0, 0, 0, 0, 255, 0, 255]).unwrap();
    let grey = image::GrayImage::from_raw(2, 1, vec![0, 51]).unwrap();
    let normal = image::RgbImage::from_raw(1, 1, vec![128, 128, 255]).unwrap();
    let mtl = b"newmtl leaf\nKd 1 1 1\nmap_Kd -clamp on leaf.png\nmap_d leaf.png\nd 0\n\
        newmtl metal\nKd 1 1 1\nPr 0.5\nmap_Pr grey.png\nmap_Pm -imfchan g leaf.png\nnorm normal.png\n\
        newmtl bumpy\nmap_Bump -bm 2 grey.png\nbump gone.png\nmap_Ke leaf.png\nKe 2 2 2\n\
        newmtl fake\nbump normal.png\nnewmtl steep\nbump -bm 2 tilted.png\nnewmtl same\nnorm -bm 2 tilted.png\n";
    let obj = with_corners(
        "mtllib m.mtl\nusemtl leaf\nf 1 2 3\nusemtl metal\nf 1 2 3\nusemtl bumpy\nf 1 2 3\nusemtl fake\nf 1 2 3\n\
            usemtl steep\nf 1 2 3\nusemtl same\nf 1 2 3\n",
    );
    let tilted = png(image::RgbImage::from_raw(1, 1, vec![140, 128, 250]).unwrap());
    let files = [
        ("m.mtl", &mtl[..]),
        ("leaf.png", &png(leaf)),
        ("grey.png", &png(grey)),
        ("normal.png", &png(normal)),
        ("tilted.png", &tilted),
    ];
    let (file, notes) = read(&obj, &files);
    let [leaf, metal, bumpy, fake, steep, same] = [0, 1, 2, 3, 4, 5].map(|i| &file.materials[i]);
    let holes = leaf.maps.opacity.as_ref().unwrap();
    assert_eq!((holes.factor, holes.texture.as_ref().unwrap().texels.as_slice()), (1.0, &[0.0, 1.0][..]));
    let Surface::Diffuse { reflectance } = &leaf.surface else { panic!("not diffuse") };
    assert_eq!(reflectance.texture.as_ref().unwrap().wrap, [crate::texture::Wrap::Clamp; 2]);
    assert!(matches!(&metal.surface, Surface::Coated { alpha: 0.25, .. }));
    assert_eq!(metal.maps.roughness.as_ref().unwrap().texels, [0.0, 0.2]);
    assert_eq!(metal.maps.metallic.as_ref().unwrap().texture.as_ref().unwrap().texels, [0.0, 1.0]);
    let plain = metal.maps.normals.as_ref().unwrap();
    assert_eq!(plain.texels, fake.maps.normals.as_ref().unwrap().texels, "a normal map by another name");
    let slope = |of: &crate::material::Material| {
        let [x, _, z] = of.maps.normals.as_ref().unwrap().texels[0].map(|part| 2.0 * part - 1.0);
        x / z
    };
    assert!((slope(steep) - 2.0 * 25.0 / 245.0).abs() < 1e-4 && slope(steep) == slope(same), "{}", slope(steep));
    assert!(bumpy.maps.normals.is_none() && bumpy.emits());
    assert_eq!(bumpy.emission.texture.as_ref().unwrap().texels[0], [1.0, 0.0, 0.0]);
    assert_eq!(notes, ["material 'bumpy': texture 'gone.png' is missing; it is left out"]);
}

#[test]
fn textures_of_sixteen_bits_and_other_formats_are_read() {
    let grey = image::ImageBuffer::<image::Luma<u16>, _>::from_raw(1, 1, vec![0x8000_u16]).unwrap();
    let colour = image::RgbImage::from_pixel(1, 1, image::Rgb([255, 255, 0]));
    let encoded = |format| {
        let mut file = std::io::Cursor::new(vec![]);
        image::DynamicImage::from(colour.clone()).write_to(&mut file, format).unwrap();
        file.into_inner()
    };
    let files = [
        ("a.png", png(grey)),
        ("b.tga", encoded(image::ImageFormat::Tga)),
        ("c.bmp", encoded(image::ImageFormat::Bmp)),
        ("d.jpg", encoded(image::ImageFormat::Jpeg)),
    ];
    let mut mtl = String::new();
    let mut obj = "mtllib m.mtl\n".to_string();
    for (name, _) in &files {
        mtl += &format!("newmtl {name}\nmap_Kd {name}\n");
        obj += &format!("usemtl {name}\nf 1 2 3\n");
    }
    let all: Vec<(&str, &[u8])> =
        files.iter().map(|(name, file)| (*name, &file[..])).chain([("m.mtl", mtl.as_bytes())]).collect();
    let (file, notes) = read(&with_corners(&obj), &all);
    assert!(notes.is_empty(), "{notes:?}");
    // The sRGB value of one half is 0.21404.
    for (material, expected) in file
        .materials
        .iter()
        .zip([Vec3::splat(0.214_04), Vec3::new(1.0, 1.0, 0.0)].iter().chain([&Vec3::new(1.0, 1.0, 0.0); 2]))
    {
        let Surface::Diffuse { reflectance } = &material.surface else { panic!("not diffuse") };
        let texel = Vec3::from_array(reflectance.texture.as_ref().unwrap().texels[0]);
        assert!((texel - expected).length() < 0.02, "{}: {texel}", material.name);
    }
}

#[test]
fn concave_faces_are_cut_and_what_is_no_face_is_said() {
    let arrow = "v 0 0 0\nv 2 -1 0\nv .5 0 0\nv 2 1 0\nf 4 1 2 3\nf 1 2 3\np 1 2\nl 1 2\nl 2 3\ncurv 0 1 1 2\n";
    let (file, notes) = read(arrow.as_bytes(), &[]);
    // The diagonal through the notch, not the one outside.
    let cut = |t: usize| file.mesh.triangles[t].map(|v| file.mesh.positions[v as usize]);
    for t in 0..2 {
        assert!(cut(t).contains(&Vec3::ZERO) && cut(t).contains(&Vec3::new(0.5, 0.0, 0.0)));
    }
    assert_eq!((file.mesh.triangles.len(), file.mesh.materials.len()), (3, 3));
    let said: Vec<_> = notes.iter().map(|n| n.split_once(": ").unwrap().1).collect();
    assert_eq!(
        said,
        ["1 statements of points left out", "2 statements of lines left out", "1 curves and curved surfaces left out"]
    );
}

#[test]
fn exponents_may_vary_and_textures_may_be_open_exr() {
    let grey = image::GrayImage::from_raw(2, 1, vec![0, 255]).unwrap();
    let size = stack::Size::new(2, 1);
    let image = stack::Image::from_channels(size, vec![vec![0.25, 3.0], vec![0.5, 0.0], vec![1.0, 0.0]]);
    let folder = TempDir::new().unwrap();
    let mut pictures = vec![];
    for name in ["a.exr", "a.pfm"] {
        stack::file::write_picture(&folder.path().join(name), &image).unwrap();
        pictures.push((name, fs::read(folder.path().join(name)).unwrap()));
    }
    let mtl = b"newmtl shiny\nKd .2 .2 .2\nKs .3 .3 .3\nNs 198\nmap_Ns grey.png\nmap_Kd a.exr\n\
        newmtl physical\nPr 0.5\nNs 198\nmap_Ns grey.png\nmap_Kd a.pfm\nnewmtl dull\nmap_Ns grey.png\n";
    let obj = with_corners("mtllib m.mtl\nusemtl shiny\nf 1 2 3\nusemtl physical\nf 1 2 3\nusemtl dull\nf 1 2 3\n");
    let grey = png(grey);
    let mut files = vec![("m.mtl", &mtl[..]), ("grey.png", &grey)];
    files.extend(pictures.iter().map(|(name, bytes)| (*name, bytes.as_slice())));
    let (file, notes) = read(&obj, &files);
    let [shiny, physical, dull] = [0, 1, 2].map(|i| &file.materials[i]);
    let Surface::Coated { alpha: 0.1, diffuse, .. } = &shiny.surface else { panic!("{:?}", shiny.surface) };
    assert_eq!(diffuse.texture.as_ref().unwrap().texels, [[0.25, 0.5, 1.0], [3.0, 0.0, 0.0]], "floats are linear");
    // α is √(2/2) where the exponent is 0, and √(2/200) where it is whole.
    let roughness = &shiny.maps.roughness.as_ref().unwrap().texels;
    assert!((0.1 * roughness[0] * roughness[0] - 1.0).abs() < 1e-6 && roughness[1] == 1.0);
    assert!(physical.maps.roughness.is_none() && dull.maps.roughness.is_none());
    assert_eq!(notes, ["material 'dull': map_Ns without Ns is ignored"]);
}
