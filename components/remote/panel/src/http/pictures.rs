//! Pictures and state of the component align, read once for all who watch.

use crate::{
    engine::Engine,
    error::{Code, Error},
};
use axum::body::Bytes;
use hal_protocol::{Reply, Request};
use serde_json::Value;
use std::{
    fs,
    io::{self, BufRead as _, BufReader, Read as _},
    path::Path,
    sync::Arc,
    time::Duration,
};
use tokio::{sync::Mutex, task::block_in_place, time::Instant};

/// Time for which the component is asked for pictures, in seconds of machine time.
const WATCHED: &str = "seconds=3";
/// Time after which it is asked again.
const AGAIN: Duration = Duration::from_secs(1);
/// Time between two looks for a new picture.
pub(super) const LOOK: Duration = Duration::from_millis(30);
/// Longest line before a picture, and largest picture, in bytes.
const MAX_VIEW: u64 = 40 << 20;

/// A picture of the camera, with what is in it.
#[derive(Debug)]
pub(super) struct View {
    pub(super) number: Option<u64>,
    pub(super) head: Value,
    pub(super) bytes: Bytes,
}

/// The newest picture, and the newest answer of the component.
#[derive(Debug, Default)]
pub(crate) struct Pictures {
    newest: Mutex<Newest>,
    known: Mutex<Option<(Instant, Arc<str>)>>,
}

#[derive(Debug, Default)]
struct Newest {
    /// When the component was asked for pictures last.
    asked: Option<Instant>,
    /// When the file was read last.
    looked: Option<Instant>,
    view: Option<Arc<View>>,
}

impl Pictures {
    /// Returns the newest picture in a file, after a look that is not older than [`LOOK`]. Once in a while, the component is
    /// asked to write pictures there.
    pub(super) async fn newest(
        &self,
        engine: &Engine,
        file: &Path,
    ) -> Result<Option<Arc<View>>, Error> {
        let mut newest = self.newest.lock().await;
        if newest.asked.is_none_or(|at| at.elapsed() >= AGAIN) {
            let args = vec![format!("file={}", file.display()), WATCHED.to_owned()];
            engine.call(Request::Command { name: "align.watch".to_owned(), args }).await?;
            newest.asked = Some(Instant::now());
        }
        let look = block_in_place(|| newest.look(file, Instant::now()));
        look.map_err(|e| super::programs::disk(&e))
    }

    /// Returns what the component knows, as the text of a JSON object. Who waits while another is answered shares the next
    /// answer: each is younger than the question.
    pub(super) async fn known(&self, engine: &Engine) -> Result<Arc<str>, Error> {
        let since = Instant::now();
        let mut known = self.known.lock().await;
        if let Some((asked, text)) = &*known
            && *asked >= since
        {
            return Ok(text.clone());
        }
        let asked = Instant::now();
        let args = vec!["json=TRUE".to_owned()];
        let request = Request::Command { name: "align.status".to_owned(), args };
        match engine.call(request).await? {
            Reply::Answer(told) => {
                let text: Arc<str> = told.lines.concat().into();
                *known = Some((asked, text.clone()));
                Ok(text)
            }
            _ => Err(Error::new(Code::Refused, "align.status has no answer")),
        }
    }
}

impl Newest {
    fn look(&mut self, file: &Path, now: Instant) -> io::Result<Option<Arc<View>>> {
        if self.looked.is_none_or(|at| now >= at + LOOK) {
            self.view = read(file, self.view.as_ref())?;
            self.looked = Some(now);
        }
        Ok(self.view.clone())
    }
}

/// Reads the picture of a file with the line before it, unless it is the one that is known. `None` without a file.
fn read(file: &Path, known: Option<&Arc<View>>) -> io::Result<Option<Arc<View>>> {
    let opened = match fs::File::open(file) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
        opened => opened?,
    };
    let mut opened = BufReader::new(opened.take(MAX_VIEW));
    let (mut line, mut bytes) = (Vec::new(), Vec::new());
    opened.read_until(b'\n', &mut line)?;
    let head: Value = serde_json::from_slice(&line)?;
    let number = head.get("number").and_then(Value::as_u64);
    if let Some(known) = known
        && number.is_some()
        && number == known.number
    {
        return Ok(Some(known.clone()));
    }
    opened.read_to_end(&mut bytes)?;
    Ok(Some(Arc::new(View { number, head, bytes: bytes.into() })))
}

#[cfg(test)]
mod tests {
    //! Many who watch: the file is read, and the component asked, once for all.

    use super::*;
    use crate::lease::tests::run;
    use hal_protocol::Answer;
    use std::{
        future::poll_fn,
        pin::{Pin, pin},
        sync::mpsc::channel,
        task::Poll,
    };

    #[test]
    fn a_picture_is_read_once_for_all() {
        let folder = std::env::temp_dir().join(format!("panel-view-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join("view");
        let (mut newest, begun) = (Newest::default(), Instant::now());
        let mut look = |n: u32| newest.look(&file, begun + n * LOOK / 2).unwrap();
        assert!(look(0).is_none());
        fs::write(&file, "{\"number\": 1}\nfirst").unwrap();
        assert!(look(1).is_none(), "the last look counts");
        let first = look(2).unwrap();
        assert_eq!((first.number, &first.bytes[..]), (Some(1), &b"first"[..]));
        fs::write(&file, "{\"number\": 2}\nsecond").unwrap();
        assert!(Arc::ptr_eq(&first, &look(3).unwrap()), "all have the same bytes");
        let second = look(4).unwrap();
        assert_eq!((second.number, &second.bytes[..]), (Some(2), &b"second"[..]));
        assert!(Arc::ptr_eq(&second, &look(6).unwrap()), "the same number");
        // Without a number each picture is another.
        fs::write(&file, "{}\nthird").unwrap();
        assert_eq!(look(8).unwrap().bytes[..], b"third"[..]);
        fs::write(&file, "{}\nfourth").unwrap();
        assert_eq!(look(10).unwrap().bytes[..], b"fourth"[..]);
        fs::remove_file(&file).unwrap();
        assert!(look(12).is_none());
        fs::remove_dir_all(&folder).unwrap();
    }

    async fn is_waiting<T>(mut work: Pin<&mut impl Future<Output = T>>) -> bool {
        poll_fn(|cx| Poll::Ready(work.as_mut().poll(cx).is_pending())).await
    }

    #[test]
    fn who_waits_for_the_same_answer_shares_it() {
        let (go, waits) = channel();
        let mut asked = 0;
        let engine = Engine::that(move |_| {
            waits.recv().unwrap();
            asked += 1;
            let lines = vec![asked.to_string()];
            Ok(Reply::Answer(Answer { lines, ticket: None, awaited: false }))
        });
        let pictures = Pictures::default();
        run(async {
            let mut first = pin!(pictures.known(&engine));
            assert!(is_waiting(first.as_mut()).await);
            let (mut second, mut third) =
                (pin!(pictures.known(&engine)), pin!(pictures.known(&engine)));
            assert!(is_waiting(second.as_mut()).await && is_waiting(third.as_mut()).await);
            (0..3).for_each(|_| go.send(()).unwrap());
            assert_eq!(&*first.await.unwrap(), "1");
            // Both have asked after the first question was sent, so that its answer may be too old.
            assert_eq!((&*second.await.unwrap(), &*third.await.unwrap()), ("2", "2"));
            assert_eq!(&*pictures.known(&engine).await.unwrap(), "3");
        });
    }
}
