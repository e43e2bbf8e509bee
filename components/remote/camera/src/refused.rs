//! Reasons why a camera gives no picture.

use core::fmt;
use hal_marks::{MAX_BYTES, PictureProblem};
use std::io;

/// Reason why a camera gives no picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// An address that is not `http://HOST[:PORT]/PATH`.
    Address,
    /// A connection that failed.
    Connection(io::ErrorKind),
    /// No bytes within the time-out, or no whole picture within two of them.
    Timeout,
    /// An answer other than 200.
    Status(u16),
    /// An answer that is not HTTP/1, or a header that is too long.
    Header,
    /// A body whose chunks do not state their sizes.
    Chunks,
    /// A stream that is not `multipart/x-mixed-replace`.
    NotStream,
    /// No boundary, or one that is too long, or missing where it must be.
    Boundary,
    /// More bytes than are allowed for a picture.
    Large,
    /// The end of the stream within a picture, or of all pictures.
    Ended,
    /// Bytes that are no picture.
    Picture(PictureProblem),
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Address => f.write_str("an address is http://HOST[:PORT]/PATH"),
            Self::Connection(kind) => write!(f, "the connection failed: {kind}"),
            Self::Timeout => f.write_str("the camera is silent, or too slow: no bytes came within the time-out, or no picture within two"),
            Self::Status(code) => write!(f, "the camera answered with status {code}, must be 200"),
            Self::Header => f.write_str("the answer is not HTTP/1, or its header is too long"),
            Self::Chunks => f.write_str("the answer's chunks do not state their sizes"),
            Self::NotStream => f.write_str(
                "the answer is no stream of pictures (multipart/x-mixed-replace): is it a still? then use shot",
            ),
            Self::Boundary => f.write_str("the stream's boundary is missing, wrong or too long"),
            Self::Large => write!(f, "a picture has more than {MAX_BYTES} bytes"),
            Self::Ended => f.write_str("the stream has ended"),
            Self::Picture(problem) => write!(f, "{problem}"),
        }
    }
}

impl From<io::Error> for Refused {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut => Self::Timeout,
            io::ErrorKind::UnexpectedEof => Self::Ended,
            io::ErrorKind::InvalidData => Self::Chunks,
            kind => Self::Connection(kind),
        }
    }
}

impl From<PictureProblem> for Refused {
    fn from(problem: PictureProblem) -> Self {
        Self::Picture(problem)
    }
}
