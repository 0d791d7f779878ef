//! Sockets between the processes of a run, made before timely sees them.
//!
//! timely's own connect loop has no deadline and does not know whether its peer runs the same plan. Ours binds,
//! connects to all lower and accepts all higher processes, exchanges a hello (index, plan digest, workers, run
//! token), and gives up after a deadline with a message that names who is missing.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

const MAGIC: &[u8; 8] = b"mmill\0v2";
const HELLO_BYTES: usize = 8 + 8 + 8 + 32 + 32;
/// Bytes of a run's token; all zero from a process that does not hold the corpus.
pub(crate) const TOKEN_BYTES: usize = 32;
const RETRY: Duration = Duration::from_millis(20);

/// Who takes part in a run.
#[derive(Clone, Debug)]
pub struct Hosts {
    /// `host:port` of every process.
    pub addresses: Vec<String>,
    /// Which of them this process is.
    pub process: usize,
    /// How long to wait for the others.
    pub deadline: Duration,
}

/// Why the processes of a run did not come together.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say it")]
pub enum MeshError {
    #[error(
        "process {process} cannot listen on {address}: {source}\n  why: it is the address of this process in the hosts file\n  try: a free port, or an address of this machine"
    )]
    Bind { process: usize, address: String, source: std::io::Error },
    #[error(
        "after {seconds} s these processes have not connected: {missing}\n  why: a run needs all its processes\n  try: start them, with the same hosts file and --process I; what was committed is safe"
    )]
    Deadline { seconds: u64, missing: String },
    #[error(
        "process {process} ({address}) runs another {what}\n  why: all processes must mill the same plan\n  try: the same program, pipeline, config, --set and -w everywhere"
    )]
    Differs { process: usize, address: String, what: &'static str },
    #[error("interrupted while waiting for the other processes")]
    Interrupted,
}

/// What a process says of itself before anything else.
#[derive(Clone, Debug)]
pub(crate) struct Hello {
    pub(crate) process: u64,
    pub(crate) workers: u64,
    /// Of the plan.
    pub(crate) digest: [u8; 32],
    /// Of the run; from process 0, which holds the corpus.
    pub(crate) token: [u8; TOKEN_BYTES],
}

/// The others, as seen from one process.
#[derive(Debug)]
pub(crate) struct Mesh {
    /// A socket for each process; None for this one.
    pub(crate) sockets: Vec<Option<TcpStream>>,
    /// Process 0's.
    pub(crate) token: [u8; TOKEN_BYTES],
}

/// Connects this process to all others.
pub(crate) fn connect(
    hosts: &Hosts,
    hello: &Hello,
    stop: impl Fn() -> bool,
    mut waiting: impl FnMut(&str),
) -> Result<Mesh, MeshError> {
    let me = hosts.process;
    let bind_error = |source| MeshError::Bind { process: me, address: hosts.addresses[me].clone(), source };
    let listener = TcpListener::bind(&hosts.addresses[me]).map_err(bind_error)?;
    listener.set_nonblocking(true).map_err(bind_error)?;
    let mut sockets: Vec<Option<TcpStream>> = hosts.addresses.iter().map(|_| None).collect();
    let mut token = hello.token;
    let start = Instant::now();
    let mut told = Duration::ZERO;
    loop {
        for (process, place) in sockets.iter_mut().enumerate().take(me) {
            if place.is_none()
                && let Some(socket) = dial(&hosts.addresses[process])
                && let Some(theirs) = greet(&socket, hello)
            {
                check(&theirs, process, hosts, hello)?;
                if process == 0 {
                    token = theirs.token;
                }
                *place = Some(socket);
            }
        }
        while let Ok((socket, _)) = listener.accept() {
            if socket.set_nonblocking(false).is_ok()
                && let Some(theirs) = greet(&socket, hello)
            {
                let process = theirs.process as usize;
                if process > me && process < sockets.len() {
                    check(&theirs, process, hosts, hello)?;
                    sockets[process] = Some(socket);
                }
            }
        }
        let missing: Vec<String> = (0..sockets.len())
            .filter(|&process| process != me && sockets[process].is_none())
            .map(|process| format!("{process} ({})", hosts.addresses[process]))
            .collect();
        if missing.is_empty() {
            return Ok(Mesh { sockets, token });
        }
        if stop() {
            return Err(MeshError::Interrupted);
        }
        if start.elapsed() > hosts.deadline {
            return Err(MeshError::Deadline { seconds: hosts.deadline.as_secs(), missing: missing.join(", ") });
        }
        if start.elapsed() - told > Duration::from_secs(5) {
            told = start.elapsed();
            waiting(&format!("waiting for process {}", missing.join(", ")));
        }
        std::thread::sleep(RETRY);
    }
}

fn dial(address: &str) -> Option<TcpStream> {
    let address = address.to_socket_addrs().ok()?.next()?;
    TcpStream::connect_timeout(&address, Duration::from_secs(1)).ok()
}

/// Says hello and hears the other's. None: not one of ours, or gone again.
fn greet(mut socket: &TcpStream, hello: &Hello) -> Option<Hello> {
    socket.set_nodelay(true).ok()?;
    socket.set_read_timeout(Some(Duration::from_secs(5))).ok()?;
    let mut bytes = Vec::with_capacity(HELLO_BYTES);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&hello.process.to_le_bytes());
    bytes.extend_from_slice(&hello.workers.to_le_bytes());
    bytes.extend_from_slice(&hello.digest);
    bytes.extend_from_slice(&hello.token);
    socket.write_all(&bytes).ok()?;
    let mut theirs = [0; HELLO_BYTES];
    match socket.read_exact(&mut theirs) {
        Err(error) if error.kind() == ErrorKind::Interrupted => return None,
        Err(_) => return None,
        Ok(()) => {}
    }
    socket.set_read_timeout(None).ok()?;
    if &theirs[..8] != MAGIC {
        return None;
    }
    Some(Hello {
        process: u64::from_le_bytes(theirs[8..16].try_into().ok()?),
        workers: u64::from_le_bytes(theirs[16..24].try_into().ok()?),
        digest: theirs[24..56].try_into().ok()?,
        token: theirs[56..].try_into().ok()?,
    })
}

fn check(theirs: &Hello, process: usize, hosts: &Hosts, ours: &Hello) -> Result<(), MeshError> {
    let differs = |what| Err(MeshError::Differs { process, address: hosts.addresses[process].clone(), what });
    if theirs.process as usize != process {
        return differs("process number");
    }
    if theirs.workers != ours.workers {
        return differs("number of workers");
    }
    if theirs.digest != ours.digest {
        return differs("plan");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn two_addresses() -> Vec<String> {
        let listeners = [TcpListener::bind("127.0.0.1:0").unwrap(), TcpListener::bind("127.0.0.1:0").unwrap()];
        listeners.iter().map(|listener| listener.local_addr().unwrap().to_string()).collect()
    }

    fn hosts(addresses: &[String], process: usize) -> Hosts {
        Hosts { addresses: addresses.to_vec(), process, deadline: Duration::from_secs(5) }
    }

    fn meet(hosts: &Hosts, plan: u8) -> Result<Mesh, MeshError> {
        let token = [b'0' + hosts.process as u8; TOKEN_BYTES];
        let hello = Hello { process: hosts.process as u64, workers: 2, digest: [plan; 32], token };
        connect(hosts, &hello, || false, |_| ())
    }

    #[test]
    fn two_processes_meet_when_they_run_the_same_plan() {
        let addresses = two_addresses();
        let other = hosts(&addresses, 1);
        let peer = std::thread::spawn(move || meet(&other, 7));
        let mesh = meet(&hosts(&addresses, 0), 7).unwrap();
        assert!(mesh.sockets[0].is_none() && mesh.sockets[1].is_some());
        let theirs = peer.join().unwrap().unwrap();
        assert!(theirs.sockets[0].is_some() && theirs.sockets[1].is_none());
        assert_eq!([mesh.token, theirs.token], [[b'0'; TOKEN_BYTES]; 2], "both have the token of process 0");
    }

    #[test]
    fn a_peer_with_another_plan_is_refused_by_both() {
        let addresses = two_addresses();
        let other = hosts(&addresses, 1);
        let peer = std::thread::spawn(move || meet(&other, 8));
        assert!(matches!(meet(&hosts(&addresses, 0), 7), Err(MeshError::Differs { .. })));
        assert!(matches!(peer.join().unwrap(), Err(MeshError::Differs { .. })));
    }

    #[test]
    fn a_peer_that_never_comes_ends_the_wait() {
        let mut alone = hosts(&two_addresses(), 0);
        alone.deadline = Duration::from_millis(100);
        let error = meet(&alone, 7).unwrap_err();
        assert!(error.to_string().contains("1 (127.0.0.1:"), "{error}");
    }
}
