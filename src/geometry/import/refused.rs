//! What is no mesh of triangles that can be read here, and what to do about it.

/// What a file is instead.
pub(super) struct Advice {
    pub problem: String,
    /// Whether it is a mesh or a CAD model all the same.
    pub is_of_mesh: bool,
}

/// First bytes, what they mean, and what is to be done.
const MODELS: [(&[u8], &str, &str); 18] = [
    (b"ISO-10303-21", "a STEP file: exact surfaces", TESSELLATE),
    (b"%!PS-Adobe", "a PostScript file", "export an OBJ"),
    (b"3D Geometry File Format", "a Rhino .3dm file", "export it from Rhino as OBJ"),
    (
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",
        "a CAD system's own part (SolidWorks, Inventor)",
        TESSELLATE,
    ),
    (b"V5_CFV2", "a CATIA V5 file", TESSELLATE),
    (b"**ABCDEFGHIJKLMNOPQRSTUVWXYZ", "a Parasolid file: exact surfaces", TESSELLATE),
    (b"Kaydara FBX Binary", "an FBX file", BLENDER),
    (b"; FBX", "an FBX file", BLENDER),
    (b"BLENDER", "a Blender file", "export it from Blender as OBJ or glTF"),
    (b"#usda", "a USD file", BLENDER),
    (b"PXR-USDC", "a USD file", BLENDER),
    (b"#VRML", "a VRML file", BLENDER),
    (b"#X3D", "an X3D file", BLENDER),
    (b"MM\0", "a 3DS file", BLENDER),
    (b"OFF", "an OFF file", "save it as PLY or OBJ, in MeshLab for one"),
    (b"DRACO", "a Draco-compressed mesh", "export it without compression"),
    (b"Version 8", "a JT file", TESSELLATE),
    (b"AutoCAD Binary DXF", "a DXF file", TESSELLATE),
];

const TESSELLATE: &str = "export a mesh from the CAD system as OBJ or STL, in mm, with a chord \
                          tolerance of 0.01 mm or less and an angle of 5° or less";
const BLENDER: &str = "export it as OBJ, PLY or glTF, from Blender for one";

const COMPRESSED: [(&[u8], &str, &str); 6] = [
    (b"\x1f\x8b", "gzip", "gunzip"),
    (b"\x28\xb5\x2f\xfd", "Zstandard", "unzstd"),
    (b"\xfd7zXZ", "xz", "unxz"),
    (b"BZh", "bzip2", "bunzip2"),
    (b"7z\xbc\xaf\x27\x1c", "7-Zip", "7z x"),
    (b"Rar!", "RAR", "unrar x"),
];

/// What is to be done with a file that is known, and is not read; `None` for all others.
pub(super) fn advice(bytes: &[u8]) -> Option<Advice> {
    let text = bytes.trim_ascii_start();
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let of_mesh = |what: &str, what_to_do: &str| {
        Some(Advice { problem: format!("is {what}: {what_to_do}"), is_of_mesh: true })
    };
    let other = |problem: String| Some(Advice { problem, is_of_mesh: false });
    if bytes.is_empty() {
        return other("is empty".to_owned());
    }
    if let Some((_, what, what_to_do)) = MODELS.iter().find(|(mark, ..)| text.starts_with(mark)) {
        return of_mesh(what, what_to_do);
    }
    if bytes.starts_with(b"PK\x03\x04") {
        return zip(bytes);
    }
    if let Some((_, what, tool)) = COMPRESSED.iter().find(|(mark, ..)| bytes.starts_with(mark)) {
        return other(format!("is compressed with {what}: unpack it first ({tool})"));
    }
    if text.starts_with(b"version https://git-lfs") {
        return other("is a Git LFS pointer and not the file itself: git lfs pull".to_owned());
    }
    if text.starts_with(b"<") {
        return xml(text);
    }
    if is_iges(bytes) {
        return of_mesh("an IGES file: exact surfaces", TESSELLATE);
    }
    if is_dxf(text) {
        return of_mesh("a DXF file", TESSELLATE);
    }
    None
}

fn zip(bytes: &[u8]) -> Option<Advice> {
    let start = &bytes[..bytes.len().min(1 << 16)];
    let holds = |what: &[u8]| start.windows(what.len()).any(|window| window == what);
    let (what, what_to_do, is_of_mesh) = if holds(b"3D/3dmodel.model") || holds(b"3dmodel") {
        ("a 3MF file", "export it as OBJ or STL, from the slicer or CAD system", true)
    } else if holds(b"Document.xml") {
        ("a FreeCAD file", "export its parts from FreeCAD as OBJ", true)
    } else {
        ("compressed with ZIP", "unpack it first (unzip)", false)
    };
    Some(Advice { problem: format!("is {what}: {what_to_do}"), is_of_mesh })
}

fn xml(text: &[u8]) -> Option<Advice> {
    let start = &text[..text.len().min(2048)];
    let holds = |what: &[u8]| start.windows(what.len()).any(|w| w.eq_ignore_ascii_case(what));
    let (what, is_of_mesh) = if holds(b"<COLLADA") {
        ("a COLLADA file", true)
    } else if holds(b"<X3D") {
        ("an X3D file", true)
    } else if holds(b"<amf") {
        ("an AMF file", true)
    } else if holds(b"<html") {
        return Some(Advice {
            problem: "is a web page: the download went wrong".to_owned(),
            is_of_mesh: false,
        });
    } else {
        return None;
    };
    Some(Advice { problem: format!("is {what}: {BLENDER}"), is_of_mesh })
}

/// Fixed lines of 80 characters, the 73rd of which names the section: S is the first.
fn is_iges(bytes: &[u8]) -> bool {
    bytes.len() >= 80
        && bytes[72] == b'S'
        && bytes[73..80].iter().all(|b| b" 0123456789".contains(b))
}

fn is_dxf(text: &[u8]) -> bool {
    let mut lines = text.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
    lines.next() == Some(b"0") && lines.next() == Some(b"SECTION")
}
