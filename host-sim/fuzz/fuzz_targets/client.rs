//! Any bytes, and any answers, at the host's end of the link: an error or an answer, in bounded time.
#![no_main]

use std::io::{Error, ErrorKind, Read, Write};
use std::time::Duration;

use er_servo::link::{Answer, Command, PACKET_BYTES, Packet, Receiver, Reply, encode};
use libfuzzer_sys::fuzz_target;
use wire::connection::{Connection, Persistence};

/// Answers each packet with the next answer of the input, or with the input as it is.
struct Stranger<'a> {
    input: &'a [u8],
    raw: bool,
    heard: Receiver,
    to_host: Vec<u8>,
}

impl Write for Stranger<'_> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Error> {
        for byte in bytes {
            let Some(Ok(Packet { sequence, .. })) = self.heard.push(*byte) else { continue };
            if self.raw {
                let (now, later) = self.input.split_at(self.input.len().min(200));
                (self.to_host, self.input) = (now.to_vec(), later);
            } else if let Ok((answer, behind)) = postcard::take_from_bytes::<Answer>(self.input) {
                self.input = behind;
                let mut packet = [0; PACKET_BYTES];
                self.to_host.extend(encode(&Reply { sequence, answer }, &mut packet).expect("every answer fits"));
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Error> {
        Ok(())
    }
}

impl Read for Stranger<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Error> {
        if self.to_host.is_empty() {
            return Err(ErrorKind::TimedOut.into());
        }
        let count = self.to_host.len().min(buffer.len());
        buffer[..count].copy_from_slice(&self.to_host[..count]);
        self.to_host.drain(..count);
        Ok(count)
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, input)) = bytes.split_first() else { return };
    let stranger = Stranger { input, raw: kind % 2 == 0, heard: Receiver::default(), to_host: Vec::new() };
    let persistence = Persistence { patience: Duration::from_micros(20), attempts: 2 };
    let Ok(mut connection) = Connection::open(stranger, persistence) else { return };
    let _ = connection.status().map_err(|error| error.to_string());
    let _ = connection.tell(Command::Enable { autonomous: true }).map_err(|error| error.to_string());
    let _ = connection.parameter("kp_nm_rad").map_err(|error| error.to_string());
    let _ = connection.set_parameters(&[("kp_nm_rad", 250.0)], false).map_err(|error| error.to_string());
});
