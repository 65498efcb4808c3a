//! Control by a Unix socket, which only its owner may open.

use std::fs::{self, DirBuilder, Permissions};
use std::io::{self, Read, Write};
use std::os::unix::fs::{DirBuilderExt, FileTypeExt, MetadataExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use super::{ControlFault, LONGEST_PATH, Lines, Subject, answers};

/// Clients at a time.
const MOST_CLIENTS: usize = 16;
/// How often an idle thread looks whether the run is over.
const GLANCE: Duration = Duration::from_millis(50);
/// How long a client may leave its answers unread.
const UNREAD_TIMEOUT: Duration = Duration::from_secs(1);

/// A socket that nobody answers yet.
#[derive(Debug)]
pub struct Socket {
    listener: UnixListener,
    path: PathBuf,
    /// Its number in the file system.
    inode: u64,
}

/// A socket whose clients are answered.
pub struct Listening {
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    // Dropped last: nobody finds a socket that nobody answers.
    _socket: Left,
}

/// Removes the file of the socket.
struct Left {
    path: PathBuf,
    inode: u64,
}

impl Drop for Left {
    fn drop(&mut self) {
        // Unless something else has taken its place.
        if fs::symlink_metadata(&self.path).is_ok_and(|data| data.ino() == self.inode) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        drop(Left { path: std::mem::take(&mut self.path), inode: self.inode });
    }
}

impl Socket {
    /// Makes the socket; one that a run has left is replaced.
    ///
    /// # Errors
    /// A path that no socket can have, or where something else is.
    pub fn make(path: &Path) -> Result<Self, ControlFault> {
        let bytes = path.as_os_str().len();
        if bytes == 0 || bytes > LONGEST_PATH || path.file_name().is_none() {
            return Err(ControlFault::TooLong { path: path.to_owned(), bytes });
        }
        if let Ok(data) = fs::symlink_metadata(path) {
            if !data.file_type().is_socket() {
                return Err(ControlFault::NotASocket { path: path.to_owned() });
            }
            if !matches!(UnixStream::connect(path), Err(error) if error.kind() == io::ErrorKind::ConnectionRefused)
            {
                return Err(ControlFault::InUse { path: path.to_owned() });
            }
        }
        let io = |action| move |source| ControlFault::Io { path: path.to_owned(), action, source };
        // Made where nobody else can look, and moved to its place when only its owner may open it.
        let folder = path.with_file_name(format!(".nereus-{}", std::process::id()));
        DirBuilder::new().mode(0o700).create(&folder).map_err(io("making a folder beside it"))?;
        let inside = folder.join("s");
        let made = (|| {
            let listener = UnixListener::bind(&inside).map_err(io("making the socket"))?;
            fs::set_permissions(&inside, Permissions::from_mode(0o600))
                .map_err(io("closing it to others"))?;
            listener.set_nonblocking(true).map_err(io("listening"))?;
            let inode = fs::symlink_metadata(&inside).map_err(io("looking at it"))?.ino();
            fs::rename(&inside, path).map_err(io("moving it to its place"))?;
            Ok(Self { listener, path: path.to_owned(), inode })
        })();
        let _ = fs::remove_file(&inside);
        let _ = fs::remove_dir(&folder);
        made
    }

    /// Answers clients from now on.
    pub fn listen(mut self, subject: Subject) -> Listening {
        let left = Left { path: std::mem::take(&mut self.path), inode: self.inode };
        let over = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&over);
        let accept = move || {
            let mut clients: Vec<JoinHandle<()>> = Vec::new();
            while !ends.load(Ordering::Acquire) {
                clients.retain(|client| !client.is_finished());
                match self.listener.accept() {
                    Ok((stream, _)) if clients.len() < MOST_CLIENTS => {
                        let (subject, ends) = (subject.clone(), Arc::clone(&ends));
                        let talk = move || talk(stream, &subject, &ends);
                        clients.extend(thread::Builder::new().name("control client".to_owned()).spawn(talk));
                    }
                    Ok((mut stream, _)) => {
                        let _ = stream.set_write_timeout(Some(GLANCE));
                        let _ = writeln!(
                            stream,
                            "error {MOST_CLIENTS} clients are connected: allowed: at most so many"
                        );
                    }
                    Err(_) => thread::sleep(GLANCE),
                }
            }
            clients.into_iter().for_each(|client| drop(client.join()));
        };
        let thread = thread::Builder::new().name("control".to_owned()).spawn(accept).ok();
        Listening { over, thread, _socket: left }
    }
}

impl Listening {
    /// Ends all conversations and removes the socket.
    pub fn close(self) {}
}

impl Drop for Listening {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Answers one client until it goes or the run is over.
fn talk(mut stream: UnixStream, subject: &Subject, over: &AtomicBool) {
    let ready = stream
        .set_nonblocking(false)
        .and_then(|()| stream.set_read_timeout(Some(GLANCE)))
        .and_then(|()| stream.set_write_timeout(Some(UNREAD_TIMEOUT)));
    if ready.is_err() {
        return;
    }
    let mut lines = Lines::default();
    let mut bytes = [0; 512];
    // Looked at whatever comes: a client that is never silent does not keep the run from ending.
    while !over.load(Ordering::Acquire) {
        match stream.read(&mut bytes) {
            Ok(0) => return,
            Ok(count) => {
                let mut gone = false;
                let mut writer = &stream;
                answers(&mut lines, &bytes[..count], subject, |answer| {
                    gone |= gone || writeln!(writer, "{answer}").is_err();
                });
                if gone {
                    return;
                }
            }
            Err(error)
                if matches!(
                    error.kind(),
                    io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted
                ) => {}
            Err(_) => return,
        }
    }
}
