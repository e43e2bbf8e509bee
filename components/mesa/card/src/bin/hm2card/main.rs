//! A simulated Mesa card at a UDP port.

mod play;

use clap::Parser;
use hal_card::{ADDRESS, Board, Card, Fate, FaultyLine, Rates, Remote, boards, remotes};
use hal_lbp16::{MAX_PACKET, PORT};
use play::{Loss, Play};
use std::{
    fmt::Display,
    fs::File,
    io::{BufWriter, Write},
    net::{Ipv4Addr, SocketAddr, UdpSocket},
    path::PathBuf,
    process::ExitCode,
    time::{Duration, SystemTime},
};

/// Simulates a Mesa card with an Ethernet port.
#[derive(Parser)]
#[command(name = "hm2card", version)]
struct Arguments {
    /// Card and firmware.
    #[arg(long, default_value = "7i92", value_parser = board)]
    board: &'static str,
    /// Address at which the card answers.
    #[arg(long, default_value_t = ADDRESS.into())]
    address: Ipv4Addr,
    /// UDP port of the card.
    #[arg(long, default_value_t = PORT)]
    port: u16,
    /// Remote at a channel of a smart-serial port.
    #[arg(long, value_name = "PORT.CHANNEL=NAME", value_parser = remote)]
    remote: Vec<(usize, usize, &'static str)>,
    /// File for what each packet reads and writes.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Nanoseconds that pass with each cycle, in place of the computer's time.
    ///
    /// A cycle is a packet that reads the levels of the I/O pins: two drivers then see the same values.
    #[arg(long, value_name = "NS")]
    step: Option<u64>,
    /// Play of what happens at the card's terminals, by cycles.
    #[arg(long, value_name = "FILE")]
    world: Option<PathBuf>,
    /// Packets per million that are lost, in either direction.
    #[arg(long, default_value_t = 0, value_name = "N")]
    lose: u32,
    /// Answers per million that come behind the next one.
    #[arg(long, default_value_t = 0, value_name = "N")]
    delay: u32,
    /// Packets per million that come twice.
    #[arg(long, default_value_t = 0, value_name = "N")]
    double: u32,
    /// Packets per million that lose their ends.
    #[arg(long, default_value_t = 0, value_name = "N")]
    shorten: u32,
    /// Seed of the faults.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn board(name: &str) -> Result<&'static str, UnknownName> {
    boards().find(|b| b.eq_ignore_ascii_case(name)).ok_or(UnknownName(boards().collect()))
}

fn remote(text: &str) -> Result<(usize, usize, &'static str), UnknownName> {
    let parts = || {
        let (place, name) = text.split_once('=')?;
        let (port, channel) = place.split_once('.')?;
        let name = remotes().find(|r| r.eq_ignore_ascii_case(name))?;
        Some((port.parse().ok()?, channel.parse().ok()?, name))
    };
    parts().ok_or(UnknownName(remotes().collect()))
}

/// Error of a name that is not in the list.
#[derive(Debug)]
struct UnknownName(Vec<&'static str>);

impl Display for UnknownName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "known are {}", self.0.join(", "))
    }
}

impl std::error::Error for UnknownName {}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&error.to_string());
            ExitCode::FAILURE
        }
    }
}

/// The card with its lines.
struct Server<'a> {
    arguments: &'a Arguments,
    card: Card,
    socket: UdpSocket,
    record: Option<BufWriter<File>>,
    there: FaultyLine,
    back: FaultyLine,
    /// Answer that comes behind the next one.
    late: Option<Vec<u8>>,
    packets: u64,
    play: Play,
    clock: Duration,
}

/// File or address that the system refuses.
#[derive(Clone, Debug)]
enum Subject {
    File(PathBuf),
    Address(SocketAddr),
    Output,
}

impl Display for Subject {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(file) => file.display().fmt(f),
            Self::Address(at) => at.fmt(f),
            Self::Output => f.write_str("standard output"),
        }
    }
}

/// Reason why the card cannot be simulated.
#[derive(Debug)]
enum Failure {
    /// The system refuses a file or an address.
    System(Subject, std::io::Error),
    /// The board has no such channel of smart serial.
    NoChannel(&'static str, usize, usize),
    /// A line of a play is no scene.
    Play(PathBuf, play::BadScene),
}

impl Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::System(subject, error) => write!(f, "{subject}: {error}"),
            Self::NoChannel(board, port, channel) => {
                write!(f, "{board} has no smart-serial channel {port}.{channel}")
            }
            Self::Play(file, bad) => write!(f, "{}: {bad}", file.display()),
        }
    }
}

impl std::error::Error for Failure {}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Some(board) = Board::named(arguments.board) else { return Ok(()) };
    let mut card = Card::new(&board);
    for (port, channel, name) in &arguments.remote {
        if !Remote::named(name).is_some_and(|remote| card.plug(*port, *channel, remote)) {
            return Err(Failure::NoChannel(arguments.board, *port, *channel));
        }
    }
    let rates = |late| Rates {
        lost: arguments.lose,
        late,
        doubled: arguments.double,
        cut: arguments.shorten,
    };
    let play = match &arguments.world {
        Some(file) => {
            let text = std::fs::read_to_string(file);
            let text = text.map_err(|e| Failure::System(Subject::File(file.clone()), e))?;
            Play::parse(&text).map_err(|bad| Failure::Play(file.clone(), bad))?
        }
        None => Play::default(),
    };
    let at = SocketAddr::from((arguments.address, arguments.port));
    let at_address = |error| Failure::System(Subject::Address(at), error);
    let in_record =
        |error| Failure::System(Subject::File(arguments.record.clone().unwrap_or_default()), error);
    let record = arguments.record.as_ref().map(File::create).transpose().map_err(in_record)?;
    let mut server = Server {
        arguments,
        card,
        socket: UdpSocket::bind(at).map_err(at_address)?,
        record: record.map(BufWriter::new),
        there: FaultyLine::new(rates(0), arguments.seed),
        back: FaultyLine::new(rates(arguments.delay), arguments.seed.wrapping_add(1)),
        late: None,
        packets: 0,
        play,
        clock: now(),
    };
    // A program that starts this one waits for this line: a packet before it would be refused.
    writeln!(std::io::stdout(), "{} at {at}", arguments.board)
        .map_err(|error| Failure::System(Subject::Output, error))?;
    let mut packet = [0; MAX_PACKET];
    loop {
        let (length, from) = server.socket.recv_from(&mut packet).map_err(at_address)?;
        let packet = packet.get(..length).unwrap_or_default();
        for length in server.there.carry(length).arrivals(length) {
            let packet = packet.get(..length).unwrap_or_default();
            server.take(packet, from).map_err(in_record)?;
        }
    }
}

/// Writes a message to standard error. If that fails, the failure cannot be reported anywhere.
fn say(text: &str) {
    drop(writeln!(std::io::stderr(), "hm2card: {text}"));
}

fn now() -> Duration {
    SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default()
}

impl Server<'_> {
    fn take(&mut self, packet: &[u8], from: SocketAddr) -> std::io::Result<()> {
        let is_cycle = self.card.reads_levels(packet);
        let cycle = is_cycle.then(|| self.play.next_cycle(&mut self.card));
        self.pass_time(is_cycle);
        self.packets += 1;
        if let Some(record) = &mut self.record {
            let cycle = cycle.map(|cycle| format!(" cycle {cycle}")).unwrap_or_default();
            writeln!(record, "packet {}{cycle}", self.packets)?;
            write!(record, "{}", self.card.recorded(packet))?;
            record.flush()?;
        }
        if self.play.loses(if is_cycle { Loss::Read } else { Loss::Write }) {
            return Ok(());
        }
        let mut answer = [0; MAX_PACKET];
        let Some(length) = self.card.answer(packet, &mut answer) else { return Ok(()) };
        if is_cycle && self.play.loses(Loss::Answer) {
            return Ok(());
        }
        let answer = answer.get(..length).unwrap_or_default();
        let late = self.late.take();
        let fate = self.back.carry(length);
        for length in fate.arrivals(length) {
            self.send(answer.get(..length).unwrap_or_default(), from);
        }
        if fate == Fate::Late {
            self.late = Some(answer.to_owned());
        }
        if let Some(late) = late {
            self.send(&late, from);
        }
        Ok(())
    }

    /// Sends an answer. One that does not go out is lost, as on a cable.
    fn send(&self, answer: &[u8], to: SocketAddr) {
        if let Err(error) = self.socket.send_to(answer, to) {
            say(&format!("{to}: {error}"));
        }
    }

    fn pass_time(&mut self, is_cycle: bool) {
        match self.arguments.step {
            Some(step) if is_cycle => self.card.advance(step),
            Some(_) => {}
            None => {
                let now = now();
                let passed = now.saturating_sub(self.clock);
                self.clock = now;
                self.card.advance(u64::try_from(passed.as_nanos()).unwrap_or(0));
            }
        }
    }
}
