//! `lampyris watch` as a browser and an editor meet it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use crate::bench::Bench;

/// A sheet whose mesh is made by a function, in a module; and a number that it prints.
const MODULE: &str = r#"
local lampyris = require "lampyris"
local tilt = 0.1
return {
  mesh = lampyris.mesh.surface {
    nu = 3, nv = 3,
    point = function(u, v) return 20 * u - 10, 20 * v - 10, tilt * u end,
  },
  color = 0.5,
}
"#;

const SCRIPT: &str = r#"
local lampyris = require "lampyris"
local part = require "part"
local scene = lampyris.scene {
  objects = { { mesh = part.mesh, material = lampyris.material { reflectance = part.color, k_d = 1 } } },
  lights = { lampyris.cylinder { center = { 0, 0, 30 }, axis = { 0, 1, 0 }, radius = 1, length = 4,
    samples = 50, flux = 100, spectrum = lampyris.spectrum.blackbody(2856) } },
}
local image = scene:render(lampyris.view { distance = 200, fov = 8, width = 160, height = 120 }, { samples = 1 })
local y = image:luminance { x = 80, y = 60 }
image:save("sheet.png")
print(("color %g, mesh %s"):format(part.color, tostring(part.mesh)), y > 0)
"#;

struct Watched {
    child: Child,
    address: String,
}

impl Drop for Watched {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Watched {
    fn start(bench: &Bench) -> Self {
        let mut command = bench.command(&["watch", "script.lua", "--quiet"]);
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
        let address = line.strip_prefix("http://").unwrap().split('/').next().unwrap().to_owned();
        Self { child, address }
    }

    /// Status and body of the answer to a request with these headers.
    fn ask(&self, method: &str, path: &str, headers: &str) -> (u16, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        write!(stream, "{method} {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n").unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("a head");
        let head = String::from_utf8_lossy(&answer[..end]).into_owned();
        (head.split(' ').nth(1).unwrap().parse().unwrap(), answer[end + 4..].to_vec())
    }

    fn get(&self, path: &str) -> (u16, Vec<u8>) {
        self.ask("GET", path, &format!("Host: {}\r\n", self.address))
    }

    fn news(&self, version: u64) -> serde_json::Value {
        serde_json::from_slice(&self.get(&format!("/news/{version}")).1).unwrap()
    }

    /// Follows the news until they are as wanted.
    fn wait(&self, is_wanted: impl Fn(&serde_json::Value) -> bool) -> serde_json::Value {
        let (start, mut version) = (Instant::now(), 0);
        loop {
            let news = self.news(version);
            if is_wanted(&news) {
                return news;
            }
            version = news["version"].as_u64().unwrap();
            assert!(start.elapsed() < Duration::from_secs(120), "{news}");
        }
    }

    fn wait_for_text(&self, status: &str, text: &str) -> serde_json::Value {
        self.wait(|news| {
            let all = format!("{}{}", news["text"].as_str().unwrap(), news["message"]);
            news["status"] == status && all.contains(text)
        })
    }
}

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("part.lua", MODULE);
    bench.write("script.lua", SCRIPT);
    bench
}

#[test]
fn edits_of_script_and_module_are_shown() {
    let bench = bench();
    let watched = Watched::start(&bench);
    let news = watched.wait_for_text("done", "color 0.5");
    let picture = &news["pictures"][0];
    assert_eq!((&picture["name"], &picture["shrink"]), (&"sheet.png".into(), &1.into()), "{news}");
    assert_eq!((&picture["width"], &picture["height"]), (&160.into(), &120.into()));
    let (status, png) = watched.get(&format!("/picture/{}", picture["version"]));
    assert_eq!((status, &png[1..4]), (200, &b"PNG"[..]));
    assert_eq!(png, std::fs::read(bench.path("out/sheet.png")).unwrap());

    bench.write("part.lua", &MODULE.replace("color = 0.5", "color = 0.25"));
    let news = watched.wait_for_text("done", "color 0.25");
    assert_eq!(news["pictures"].as_array().unwrap().len(), 1, "in the place of the one before");
    bench.write("part.lua", &MODULE.replace("tilt = 0.1", "tilt = 5"));
    watched.wait_for_text("done", "5]");
    bench.write("part.lua", &MODULE.replace("tilt = 0.1", "tilt = nothing"));
    let failed = watched.wait_for_text("failed", "part.lua:7");
    assert_eq!(failed["pictures"][0]["is_from_this_run"], false, "the last good one stays");
    bench.write("script.lua", "error 'no more'");
    watched.wait_for_text("failed", "no more");
    bench.write("part.lua", MODULE);
    bench.write("script.lua", SCRIPT);
    watched.wait_for_text("done", "color 0.5");
}

#[test]
fn an_edit_stops_a_run_that_has_become_stale() {
    let bench = bench();
    bench.write("script.lua", "while true do end");
    let watched = Watched::start(&bench);
    watched.wait(|news| news["status"] == "running");
    bench.write("script.lua", SCRIPT);
    watched.wait_for_text("done", "color 0.5");
}

#[test]
fn only_this_machines_own_page_is_answered() {
    let bench = bench();
    let watched = Watched::start(&bench);
    let port = watched.address.rsplit(':').next().unwrap();
    let host = format!("Host: localhost:{port}\r\n");
    for path in ["/", "/page.js", "/page.css"] {
        let (status, body) = watched.ask("GET", path, &host);
        assert!(status == 200 && !body.is_empty(), "{path}");
    }
    let refused = [
        "Host: example.com\r\n".to_owned(),
        format!("Host: example.com:{port}\r\n"),
        String::new(),
        format!("{host}Sec-Fetch-Site: cross-site\r\n"),
        format!("{host}Origin: http://example.com\r\n"),
        format!("{host}Origin: null\r\n"),
    ];
    for headers in refused {
        let status = watched.ask("GET", "/news/0", &headers).0;
        assert!(matches!(status, 400 | 403), "{headers}: {status}");
    }
    for path in
        ["/script.lua", "/../script.lua", "/picture/../part.lua", "/picture/99999", "/news/x"]
    {
        assert_eq!(watched.get(path).0, 404, "{path}");
    }
    assert_eq!(watched.ask("POST", "/", &format!("{host}Content-Length: 0\r\n")).0, 405);
}

#[test]
fn a_viewer_that_listens_gets_the_pictures() {
    // tev's own address, which may be taken on this machine.
    let Ok(viewer) = TcpListener::bind("127.0.0.1:14158") else { return };
    let bench = bench();
    let _watched = Watched::start(&bench);
    let mut stream = viewer.accept().unwrap().0;
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let mut message = || {
        let mut length = [0; 4];
        stream.read_exact(&mut length).unwrap();
        let mut body = vec![0; u32::from_le_bytes(length) as usize - 4];
        stream.read_exact(&mut body).unwrap();
        body
    };
    let name = b"lampyris: render 1\0";
    let mut picture = || {
        let (create, update) = (message(), message());
        assert_eq!((create[0], &create[2..2 + name.len()]), (4, &name[..]));
        let size = &create[2 + name.len()..][..8];
        assert_eq!(size, [160i32.to_le_bytes(), 120i32.to_le_bytes()].concat());
        assert_eq!((update[0], &update[2..2 + name.len()]), (6, &name[..]));
        let values = update[update.len() - 4 * 160 * 120 * 3..].chunks(4);
        values.map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect::<Vec<_>>()
    };
    let at = |picture: &[f32], x: usize, y: usize| picture[3 * (160 * y + x)];
    let (coarse, fine) = (picture(), picture());
    assert!(at(&coarse, 0, 0) == 0.0 && at(&coarse, 80, 60) > 0.0, "the sheet before black");
    let is_coarse =
        |picture: &[f32]| (0..80).all(|x| at(picture, 2 * x, 61) == at(picture, 2 * x + 1, 60));
    assert!(is_coarse(&coarse) && !is_coarse(&fine));
}
