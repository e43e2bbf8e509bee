//! A small server on this computer that behaves well, or badly.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use camera::{Address, Delivery, Feed, Refused};
use hal_marks::PictureProblem;
use std::{
    io::{Read, Write},
    net::TcpListener,
    thread,
    time::Duration,
};

/// Serves the same bytes to every connection; keeps it open after them if `stays` is set. Returns the address.
fn server(bytes: Vec<u8>, stays: bool) -> Address {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    drop(thread::spawn(move || {
        let mut open = Vec::new();
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let mut request = [0; 1000];
            let n = stream.read(&mut request).unwrap();
            assert!(request[..n].starts_with(b"GET /video HTTP/1.1\r\nHost: 127.0.0.1:"));
            // A client that has heard enough hangs up.
            drop(stream.write_all(&bytes));
            if stays {
                open.push(stream);
            }
        }
    }));
    Address::parse(&format!("http://127.0.0.1:{port}/video")).unwrap()
}

fn jpeg(level: u8) -> Vec<u8> {
    let mut out = Vec::new();
    let encoder = jpeg_encoder::Encoder::new(&mut out, 90);
    encoder.encode(&[level; 64 * 48], 64, 48, jpeg_encoder::ColorType::Luma).unwrap();
    out
}

fn stream(parts: &[Vec<u8>]) -> Vec<u8> {
    let mut out =
        b"HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=b\r\n\r\n".to_vec();
    for part in parts {
        out.extend(format!("--b\r\nContent-Length: {}\r\n\r\n", part.len()).bytes());
        out.extend(part);
        out.extend(b"\r\n");
    }
    out
}

fn still(body: &[u8]) -> Vec<u8> {
    let mut out = format!("HTTP/1.1 200 OK\r\nContent-Length: {}\r\n\r\n", body.len()).into_bytes();
    out.extend(body);
    out
}

const SECOND: Duration = Duration::from_secs(1);

fn first(kind: Delivery, bytes: Vec<u8>, stays: bool) -> Result<(usize, u8), Refused> {
    let mut feed = Feed::start(kind, server(bytes, stays), SECOND);
    feed.take().map(|(_, picture, _)| (picture.width(), picture.at(9, 9)))
}

#[test]
fn the_newest_picture_of_a_stream_wins() {
    let parts: Vec<_> = (0..100).map(|n| jpeg(n * 2)).collect();
    let mut feed = Feed::start(Delivery::Mjpeg, server(stream(&parts), false), 5 * SECOND);
    let (mut taken, mut lost, mut level) = (0, 0, 0);
    let end = loop {
        match feed.take() {
            Ok((_, picture, missed)) => {
                assert!(taken == 0 || picture.at(9, 9) > level, "pictures come in their order");
                (taken, lost, level) = (taken + 1, lost + missed, picture.at(9, 9));
            }
            Err(refused) => break refused,
        }
    };
    assert_eq!(end, Refused::Ended);
    assert_eq!((taken + lost, level), (100, 198));
}

#[test]
fn stills_are_taken_one_by_one() {
    let mut feed = Feed::start(Delivery::Shot, server(still(&jpeg(50)), false), 5 * SECOND);
    for _ in 0..3 {
        let (bytes, picture, _) = feed.take().unwrap();
        assert_eq!((picture.width(), picture.at(9, 9)), (64, 50));
        assert_eq!(bytes, jpeg(50));
    }
}

#[test]
fn a_camera_that_behaves_badly_is_refused_by_name() {
    let broken = Err(Refused::Picture(PictureProblem::Broken));
    let cut = jpeg(9)[..200].to_vec();
    assert_eq!(first(Delivery::Mjpeg, stream(std::slice::from_ref(&cut)), false), broken);
    assert_eq!(first(Delivery::Shot, still(&cut), false), broken);
    let garbage = Err(Refused::Picture(PictureProblem::Format));
    assert_eq!(first(Delivery::Mjpeg, stream(&[b"hello".to_vec()]), false), garbage);
    assert_eq!(first(Delivery::Mjpeg, still(&jpeg(9)), false), Err(Refused::NotStream));
    let other = b"HTTP/1.1 404 Not Found\r\n\r\n".to_vec();
    assert_eq!(first(Delivery::Mjpeg, other, false), Err(Refused::Status(404)));
    assert_eq!(first(Delivery::Mjpeg, b"SSH-2.0-x\r\n\r\n".to_vec(), false), Err(Refused::Header));
    assert_eq!(first(Delivery::Mjpeg, Vec::new(), false), Err(Refused::Ended));
    let mut wrong = stream(&[]);
    wrong.extend(b"--c\r\n\r\nabc\r\n".repeat(1000));
    assert_eq!(first(Delivery::Mjpeg, wrong, false), Err(Refused::Boundary));
    let mut large = stream(&[]);
    large.extend(b"--b\r\nContent-Length: 99999999999\r\n\r\n");
    assert_eq!(first(Delivery::Mjpeg, large, true), Err(Refused::Large));
    let large = b"HTTP/1.1 200 OK\r\nContent-Length: x\r\n\r\n".to_vec();
    assert_eq!(first(Delivery::Shot, large, true), Err(Refused::Header));
    let chunks = b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n-1\r\nabc".to_vec();
    assert_eq!(first(Delivery::Shot, chunks, true), Err(Refused::Chunks));
    // A camera that stops in the middle.
    let mut silent = stream(&[]);
    silent.extend(b"--b\r\nContent-Length: 100\r\n\r\nabc");
    assert_eq!(first(Delivery::Mjpeg, silent, true), Err(Refused::Timeout));
    let nobody = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let address = Address::parse(&format!("http://{nobody}/")).unwrap();
    let refused = Feed::start(Delivery::Shot, address, SECOND).take().err().unwrap();
    assert!(matches!(refused, Refused::Connection(_)), "{refused}");
}
