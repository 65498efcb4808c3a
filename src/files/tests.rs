use super::*;
use listing::listing;

#[path = "../../tests/support/listing.rs"]
mod listing;

fn draft(path: &Path, text: &str) -> Draft {
    let (mut draft, _) = Draft::file(path).unwrap();
    fs::write(draft.path(), text).unwrap();
    draft.lock();
    draft
}

/// Why a complete output is not in its place, and where it is.
fn kept(finished: Result<Option<PathBuf>, FileFault>) -> (FileFault, PathBuf) {
    match finished {
        Err(FileFault::Kept { why, at, .. }) => (*why, at),
        other => panic!("{other:?}"),
    }
}

const OURS: Recognise = &|path| {
    let is_ours = fs::read(path).is_ok_and(|bytes| bytes.starts_with(b"ours"));
    is_ours.then_some(Holding::File).ok_or("file of ours")
};

#[test]
fn what_is_there_is_exchanged_only_complete_and_only_if_recognised() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a");
    fs::write(&path, "ours, old").unwrap();
    let (why, at) = kept(draft(&path, "x").finish(false, OURS));
    assert!(matches!(why, FileFault::Exists { .. }), "{why}");
    fs::remove_file(at).unwrap();
    let mut new = draft(&path, "ours, new");
    new.place_early(true).unwrap();
    assert!(!new.is_in_place() && fs::read(&path).unwrap() == b"ours, old");
    assert_eq!(new.finish(true, OURS).unwrap().as_deref(), Some(path.as_path()));
    assert_eq!(
        (fs::read(&path).unwrap().as_slice(), listing(dir.path())),
        (&b"ours, new"[..], vec!["a".into()])
    );
    fs::write(&path, "a letter").unwrap();
    let refused = draft(&path, "ours, too").finish(true, OURS);
    let text = refused.as_ref().unwrap_err().to_string();
    let (why, at) = kept(refused);
    assert!(matches!(why, FileFault::Foreign { .. }), "{why}");
    // The error names the new output, and how it gets its name.
    assert_eq!((fs::read(&at).unwrap(), fs::read(&path).unwrap()), (b"ours, too".into(), b"a letter".into()));
    let rename = format!("(mv -n {} {})", at.display(), path.display());
    assert!(text.contains("is complete and stays as") && text.ends_with(&rename), "{text}");
}

#[test]
fn a_locked_output_stays() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a");
    let mut writer = draft(&path, "ours, growing");
    writer.place().unwrap();
    assert!(matches!(preflight(&path, true, OURS), Err(FileFault::InUse { .. })));
    let (why, at) = kept(draft(&path, "ours, kept").finish(true, OURS));
    assert!(matches!(why, FileFault::InUse { .. }) && fs::read(at).unwrap() == b"ours, kept", "{why}");
    writer.finish(false, OURS).unwrap();
    draft(&path, "ours, next").finish(true, OURS).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"ours, next");
}

#[test]
fn only_what_was_made_is_removed() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a");
    let mut made = draft(&path, "ours");
    made.place().unwrap();
    // Somebody removes it and puts something else there.
    fs::write(dir.path().join("b"), "a letter").unwrap();
    fs::rename(dir.path().join("b"), &path).unwrap();
    made.abandon();
    assert_eq!(fs::read(&path).unwrap(), b"a letter");
    draft(&dir.path().join("c"), "ours").abandon();
    assert_eq!(listing(dir.path()), ["a"]);
}

#[test]
fn a_folder_goes_with_its_own_files_only() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    for name in ["a/b/c.bin", "a/d.bin", "e.bin"] {
        fs::create_dir_all(path.join(name).parent().unwrap()).unwrap();
        fs::write(path.join(name), "").unwrap();
    }
    let holding = Holding::Folder(["a/b/c.bin", "a/d.bin", "e.bin"].map(PathBuf::from).into());
    fs::write(path.join("diary.txt"), "dear").unwrap();
    assert!(old::remove(&path, &holding).is_err());
    assert_eq!(listing(&path), ["diary.txt"]);
}

#[test]
fn many_at_once_leave_one() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a");
    let won: usize = std::thread::scope(|scope| {
        let runs: Vec<_> = (0..8)
            .map(|n| {
                let path = &path;
                scope
                    .spawn(move || usize::from(draft(path, &format!("ours {n}")).finish(false, OURS).is_ok()))
            })
            .collect();
        runs.into_iter().map(|run| run.join().unwrap()).sum()
    });
    // The others are complete, too, and stay beside it.
    assert_eq!((won, listing(dir.path()).len()), (1, 8));
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_devices_left() {
    let dir = tempfile::tempdir().unwrap();
    let (path, link) = (dir.path().join("a"), dir.path().join("link"));
    fs::write(&path, "ours").unwrap();
    std::os::unix::fs::symlink(&path, &link).unwrap();
    draft(&link, "ours, new").finish(true, OURS).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read(&path).unwrap(), b"ours, new");
    assert!(matches!(preflight("/dev/null".as_ref(), true, OURS), Err(FileFault::Foreign { .. })));
    let long = dir.path().join("n".repeat(255));
    draft(&long, "ours").finish(false, OURS).unwrap();
    assert!(long.exists());
}

#[cfg(unix)]
#[test]
fn an_output_that_another_program_removes_or_moves_is_reported() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let growing = |name: &str| {
        let mut growing = draft(&at(name), "ours");
        growing.place().unwrap();
        growing
    };
    let removed = growing("a");
    fs::remove_file(at("a")).unwrap();
    let fault = removed.finish(false, OURS).unwrap_err();
    assert!(matches!(&fault, FileFault::Removed { path } if *path == at("a")), "{fault}");
    // Removed, and something else in its place.
    let replaced = growing("b");
    fs::write(at("c"), "a letter").unwrap();
    fs::rename(at("c"), at("b")).unwrap();
    let fault = replaced.finish(false, OURS).unwrap_err();
    assert!(matches!(&fault, FileFault::Removed { path } if *path == at("b")), "{fault}");
    assert_eq!(fs::read(at("b")).unwrap(), b"a letter");
    // A folder.
    let mut folder = Draft::named(&at("d"));
    fs::create_dir(folder.path()).unwrap();
    folder.made(Holding::Folder(Vec::new())).unwrap();
    folder.place().unwrap();
    fs::remove_dir(at("d")).unwrap();
    assert!(matches!(folder.finish(false, OURS), Err(FileFault::Removed { .. })));
    // Beside its place.
    let hidden = draft(&at("e"), "ours");
    fs::remove_file(hidden.path()).unwrap();
    assert!(matches!(hidden.finish(true, OURS), Err(FileFault::Removed { .. })));
    // One that was handed on may go, and then nothing is known of it.
    let mut on = growing("f");
    on.hand_on();
    fs::rename(at("f"), at("g")).unwrap();
    assert_eq!(on.finish(false, OURS).unwrap(), None);
}

#[cfg(target_os = "linux")]
#[test]
fn an_output_that_was_moved_is_found() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    fs::create_dir(at("store")).unwrap();
    let mut moved = draft(&at("a"), "ours");
    moved.place().unwrap();
    fs::rename(at("a"), at("store/a")).unwrap();
    assert_eq!(moved.present().unwrap(), at("store/a"));
    assert_eq!(moved.finish(false, OURS).unwrap(), Some(at("store/a")));
    // Its name is taken: that it is not there has to be reported.
    let mut displaced = draft(&at("b"), "ours");
    displaced.place().unwrap();
    fs::rename(at("b"), at("store/b")).unwrap();
    fs::write(at("b"), "a letter").unwrap();
    let fault = displaced.finish(true, OURS).unwrap_err();
    assert!(matches!(&fault, FileFault::Moved { now: Some(now), .. } if *now == at("store/b")), "{fault}");
    assert_eq!(fs::read(at("b")).unwrap(), b"a letter");
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_removed_is_left_whole() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    fs::create_dir_all(path.join("nav")).unwrap();
    for name in ["a.bin", "nav/b.bin"] {
        fs::write(path.join(name), "").unwrap();
    }
    let set = |mode| fs::set_permissions(path.join("nav"), fs::Permissions::from_mode(mode)).unwrap();
    set(0o555);
    if fs::write(path.join("nav/probe"), "").is_ok() {
        println!("skipped: this user may write everywhere");
        return;
    }
    let whole: Recognise = &|_| Ok(Holding::Folder(["a.bin", "nav/b.bin"].map(PathBuf::from).into()));
    let refused = preflight(&path, true, whole).unwrap_err();
    assert!(
        refused.to_string().contains("nav: not overwritten, because nothing in it can be removed"),
        "{refused}"
    );
    let (why, _) = kept(draft(&path, "ours").finish(true, whole));
    assert!(matches!(why, FileFault::Io { .. }), "{why}");
    assert_eq!((listing(&path).len(), listing(&path.join("nav")).len()), (2, 1));
    set(0o755);
    draft(&path, "ours").finish(true, whole).unwrap();
    assert!(path.is_file());
}

#[cfg(unix)]
#[test]
fn one_output_has_one_spelling() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    fs::create_dir(at("rec")).unwrap();
    fs::write(at("a"), "ours").unwrap();
    for (to, link) in [("rec", "link"), ("a", "b"), (".", "here")] {
        std::os::unix::fs::symlink(at(to), at(link)).unwrap();
    }
    for (one, other) in
        [("rec", "link"), ("rec", "here/link"), ("a", "b"), ("new", "here/new"), ("new", "./new")]
    {
        assert_eq!(spelling(&at(one)), spelling(&at(other)), "{one}, {other}");
    }
    assert_ne!(spelling(&at("a")), spelling(&at("new")));
}
