//! Pictures for tev, the image viewer, where one listens.

use std::io::Write;
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::time::Duration;

use crate::color::rec709_from_xyz;
use crate::image::SpectralImage;

/// Where tev listens unless it is told otherwise.
const ADDRESS: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 14158);

/// Longest wait for a viewer that does not read.
const PATIENCE: Duration = Duration::from_millis(500);

/// tev's numbers of its messages.
const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;

/// A connection, while there is one.
#[derive(Debug, Default)]
pub(super) struct Tev(Option<TcpStream>);

impl Tev {
    /// Looks whether a viewer listens, if none did so far.
    pub fn connect(&mut self) {
        if self.0.is_none() {
            self.0 = TcpStream::connect_timeout(&ADDRESS, PATIENCE).ok();
            let _ = self.0.as_ref().map(|stream| stream.set_write_timeout(Some(PATIENCE)));
        }
    }

    /// Shows linear Rec. 709; a picture that is `shrink` times smaller than `size` fills it.
    pub fn send(&mut self, name: &str, image: &SpectralImage, size: [usize; 2], shrink: usize) {
        let Some(stream) = &mut self.0 else { return };
        let sent = stream.write_all(&messages(name, image, size, shrink));
        if sent.is_err() {
            self.0 = None; // it was closed, or does not read
        }
    }
}

/// Makes an image, or takes the place of the one of this name, and fills it.
fn messages(
    name: &str,
    image: &SpectralImage,
    [width, height]: [usize; 2],
    shrink: usize,
) -> Vec<u8> {
    let size = [width, height].map(|side| side as i32);
    let mut create = head(CREATE_IMAGE, name);
    create.extend(size.iter().flat_map(|side| side.to_le_bytes()));
    create.extend(channels());
    let mut update = head(UPDATE_IMAGE, name);
    update.extend(channels());
    update.extend([0, 0, size[0], size[1]].iter().flat_map(|side| side.to_le_bytes()));
    let (offsets, strides) = ([0i64, 1, 2], [3i64; 3]);
    update.extend(offsets.iter().chain(&strides).flat_map(|at| at.to_le_bytes()));
    let colors: Vec<[f64; 3]> =
        image.to_xyz().pixels.iter().map(|&xyz| rec709_from_xyz(xyz)).collect();
    for y in 0..height {
        let row = &colors[y / shrink * image.width..];
        let pixels = (0..width).flat_map(|x| row[x / shrink]);
        update.extend(pixels.flat_map(|value| (value as f32).to_le_bytes()));
    }
    [create, update].into_iter().flat_map(with_length).collect()
}

/// What it is, whether it comes to the front, and the image's name.
fn head(message: u8, name: &str) -> Vec<u8> {
    let mut bytes = vec![message, 0];
    bytes.extend(name.bytes().filter(|&byte| byte != 0));
    bytes.push(0);
    bytes
}

fn channels() -> impl Iterator<Item = u8> {
    3i32.to_le_bytes().into_iter().chain(*b"R\0G\0B\0")
}

/// The length counts its own four bytes.
fn with_length(message: Vec<u8>) -> Vec<u8> {
    let length = (message.len() + 4) as u32;
    let mut bytes = length.to_le_bytes().to_vec();
    bytes.extend(message);
    bytes
}
