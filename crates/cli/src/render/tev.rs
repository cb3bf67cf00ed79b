//! Live preview in the image viewer tev (Müller), which listens for pictures over TCP.

use std::io::{ErrorKind, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::Mutex;
use std::time::Duration;

use anyhow::{Context, Result};
use stack::{Image, Size};

use crate::failure::usage;
use crate::options::Address;
use crate::progress::Progress;

/// How long a viewer that does not answer is waited for.
const PATIENCE: Duration = Duration::from_secs(5);

/// What is shown: the picture, and its estimated squared error.
const CHANNELS: [&str; 4] = ["R", "G", "B", "mse.Y"];

/// A picture in tev.
pub struct Preview {
    name: String,
    /// `None` once the viewer has gone.
    viewer: Mutex<Option<TcpStream>>,
}

impl Preview {
    /// Makes a picture of `size` called `name` in the tev at `address`.
    ///
    /// # Errors
    /// When nothing listens there.
    pub fn open(address: &Address, name: &str, size: Size) -> Result<Self> {
        let nobody = || usage(format!("--tev: nothing listens at {}; start tev first", address.0));
        let unknown = |error| usage(format!("--tev {}: no such host: {error}", address.0));
        let mut all = address.0.to_socket_addrs().map_err(unknown)?;
        let mut viewer =
            all.find_map(|address| TcpStream::connect_timeout(&address, PATIENCE).ok()).ok_or_else(nobody)?;
        viewer.set_write_timeout(Some(PATIENCE))?;
        viewer
            .write_all(&creation(name, size))
            .with_context(|| format!("--tev {}: cannot be written to", address.0))?;
        Ok(Self { name: name.into(), viewer: Mutex::new(Some(viewer)) })
    }

    /// Shows a picture and its estimated squared error. A viewer that has gone is said once and done without.
    pub fn show(&self, picture: &Image, mse: &[f32], progress: &Progress) {
        let Ok(mut viewer) = self.viewer.lock() else { return };
        let Some(stream) = viewer.as_mut() else { return };
        if let Err(error) = stream.write_all(&update(&self.name, picture, mse)) {
            let why = match error.kind() {
                ErrorKind::BrokenPipe | ErrorKind::ConnectionReset => "tev has gone".into(),
                _ => format!("tev cannot be reached any more: {error}"),
            };
            progress.say(&format!("{why}; the render goes on without it"));
            *viewer = None;
        }
    }
}

/// The message that makes a picture (type 4 of the protocol).
fn creation(name: &str, size: Size) -> Vec<u8> {
    let mut message = Message::new(4, true, name);
    message.numbers(&[size.width, size.height, CHANNELS.len()]);
    CHANNELS.iter().for_each(|channel| message.text(channel));
    message.finished()
}

/// The message that replaces its pixels (type 6), which come channel after channel in every pixel.
fn update(name: &str, picture: &Image, mse: &[f32]) -> Vec<u8> {
    let (size, count) = (picture.size(), CHANNELS.len());
    let mut message = Message::new(6, false, name);
    message.numbers(&[count]);
    CHANNELS.iter().for_each(|channel| message.text(channel));
    message.numbers(&[0, 0, size.width, size.height]);
    let offsets = (0..count as i64).chain(std::iter::repeat_n(count as i64, count));
    message.0.extend(offsets.flat_map(i64::to_le_bytes));
    message.0.reserve(16 * size.pixels());
    for (pixel, mse) in mse.iter().enumerate() {
        let [r, g, b] = picture.rgb(pixel);
        message.0.extend([r, g, b, *mse].iter().flat_map(|value| value.to_le_bytes()));
    }
    message.finished()
}

/// A message: its length, its type, whether the picture is brought to the front, the picture's name, and the rest.
struct Message(Vec<u8>);

impl Message {
    fn new(kind: u8, to_the_front: bool, name: &str) -> Self {
        let mut message = Self(vec![0, 0, 0, 0, kind, u8::from(to_the_front)]);
        message.text(name);
        message
    }

    fn text(&mut self, text: &str) {
        self.0.extend(text.bytes().filter(|byte| *byte != 0));
        self.0.push(0);
    }

    fn numbers(&mut self, numbers: &[usize]) {
        self.0.extend(numbers.iter().flat_map(|number| (*number as i32).to_le_bytes()));
    }

    fn finished(mut self) -> Vec<u8> {
        let length = self.0.len() as u32;
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        self.0
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;
    use std::net::TcpListener;

    use super::*;
    use crate::args::ReportArgs;

    /// What the viewer's own client (`tevclient` 1.0.4 on PyPI) sends to make a picture of 2×1 pixels called "a", and to fill it
    /// with the numbers from 1 to 8.
    const MADE: &str = "20000000040161000200000001000000040000005200470042006d73652e5900";
    const FILLED: &str = "8800000006006100040000005200470042006d73652e590000000000000000000200000001000000\
        0000000000000000010000000000000002000000000000000300000000000000\
        0400000000000000040000000000000004000000000000000400000000000000\
        0000803f0000004000004040000080400000a0400000c0400000e04000000041";

    fn hexadecimal(bytes: &[u8]) -> String {
        bytes.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    fn picture() -> (Image, [f32; 2]) {
        (Image::from_channels(Size::new(2, 1), vec![vec![1.0, 5.0], vec![2.0, 6.0], vec![3.0, 7.0]]), [4.0, 8.0])
    }

    #[test]
    fn messages_are_those_of_the_viewers_own_client() {
        assert_eq!(hexadecimal(&creation("a", Size::new(2, 1))), MADE);
        let (picture, mse) = picture();
        assert_eq!(hexadecimal(&update("a", &picture, &mse)), FILLED);
    }

    #[test]
    fn a_viewer_is_sent_pictures_and_may_go() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = Address(listener.local_addr().unwrap().to_string());
        let preview = Preview::open(&address, "a", Size::new(2, 1)).unwrap();
        let (mut viewer, _) = listener.accept().unwrap();
        let progress = Progress::new(&ReportArgs { quiet: true, ..ReportArgs::default() });
        let (picture, mse) = picture();
        preview.show(&picture, &mse, &progress);
        let mut received = vec![0; (MADE.len() + FILLED.len()) / 2];
        viewer.read_exact(&mut received).unwrap();
        assert_eq!(hexadecimal(&received), format!("{MADE}{FILLED}"));
        drop((viewer, listener));
        // The system notices on the second or third try.
        (0..100).for_each(|_| preview.show(&picture, &mse, &progress));
        assert!(preview.viewer.lock().unwrap().is_none());
        let refused = Preview::open(&address, "a", Size::new(2, 1)).err().unwrap();
        assert!(refused.to_string().ends_with("start tev first"), "{refused}");
        let refused = Preview::open(&Address("no such host:1".into()), "a", Size::new(2, 1)).err().unwrap();
        assert!(refused.is::<crate::failure::UsageError>(), "{refused}");
    }
}
