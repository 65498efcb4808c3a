use super::*;

fn listing(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

fn draft(path: &Path, text: &str) -> Draft {
    let (mut draft, _) = Draft::file(path).unwrap();
    fs::write(draft.path(), text).unwrap();
    draft.lock();
    draft
}

const OURS: Recognise = &|path| fs::read(path).is_ok_and(|b| b.starts_with(b"ours")).then_some(Holding::File);

#[test]
fn what_is_there_is_exchanged_only_complete_and_only_if_recognised() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a");
    fs::write(&path, "ours, old").unwrap();
    assert!(matches!(draft(&path, "x").finish(false, OURS), Err(FileFault::Exists { .. })));
    let mut new = draft(&path, "ours, new");
    new.place_early(true).unwrap();
    assert!(!new.is_in_place() && fs::read(&path).unwrap() == b"ours, old");
    assert_eq!(new.finish(true, OURS).unwrap(), path);
    assert_eq!(
        (fs::read(&path).unwrap().as_slice(), listing(dir.path())),
        (&b"ours, new"[..], vec!["a".into()])
    );
    fs::write(&path, "a letter").unwrap();
    assert!(matches!(draft(&path, "ours").finish(true, OURS), Err(FileFault::Foreign { .. })));
    assert_eq!(
        (fs::read(&path).unwrap().as_slice(), listing(dir.path())),
        (&b"a letter"[..], vec!["a".into()])
    );
}

#[test]
fn a_locked_output_stays() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a");
    let mut writer = draft(&path, "ours, growing");
    writer.place().unwrap();
    assert!(matches!(preflight(&path, true, OURS), Err(FileFault::InUse { .. })));
    assert!(matches!(draft(&path, "ours").finish(true, OURS), Err(FileFault::InUse { .. })));
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
    assert!(remove(&path, &holding).is_err());
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
    assert_eq!((won, listing(dir.path())), (1, vec!["a".to_owned()]));
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
