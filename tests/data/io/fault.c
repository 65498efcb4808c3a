/* Lets one call of the system fail, for tests: the NEREUS_FAULT_AT-th (from 1) open, write, truncate, fsync, rename or
 * mkdir that concerns a path with NEREUS_FAULT_PATH in it. With NEREUS_FAULT_STAYS all later ones that need room fail too,
 * as on a disk that stays full. With NEREUS_FAULT_LOG syncs, renames and removals go to standard error, a line each with
 * their path. Preloaded: cc -shared -fPIC -o fault.so fault.c -ldl */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

static atomic_long calls;

static int concerns(const char *path) {
    const char *part = getenv("NEREUS_FAULT_PATH");
    return path && part && strstr(path, part);
}

static int concerns_fd(int fd) {
    char name[64], path[4096];
    snprintf(name, sizeof name, "/proc/self/fd/%d", fd);
    ssize_t n = readlink(name, path, sizeof path - 1);
    if (n <= 0) return 0;
    path[n] = 0;
    return concerns(path);
}

/* Of a file or folder: the path of the descriptor, where there is one. */
static void note(const char *call, int fd, const char *path) {
    char name[64], named[4096];
    if (!getenv("NEREUS_FAULT_LOG")) return;
    if (!path) {
        snprintf(name, sizeof name, "/proc/self/fd/%d", fd);
        ssize_t n = readlink(name, named, sizeof named - 1);
        if (n <= 0) return;
        named[n] = 0;
        path = named;
    }
    if (concerns(path)) dprintf(2, "io-call %s %s\n", call, path);
}

static int fails(const char *call, int needs_room) {
    const char *at = getenv("NEREUS_FAULT_AT");
    if (!at) return 0;
    long wanted = atol(at), now = atomic_fetch_add(&calls, 1) + 1;
    if (now == wanted) dprintf(2, "io-fault %ld %s\n", now, call);
    if (now == wanted || (now > wanted && needs_room && getenv("NEREUS_FAULT_STAYS"))) {
        errno = needs_room ? ENOSPC : EIO;
        return 1;
    }
    return 0;
}

#define REAL(type, name, ...) ((type(*)(__VA_ARGS__))dlsym(RTLD_NEXT, name))

#define OPEN(name)                                                                    \
    int name(const char *path, int flags, ...) {                                      \
        mode_t mode = 0;                                                              \
        if (flags & (O_CREAT | O_TMPFILE)) {                                          \
            va_list list;                                                             \
            va_start(list, flags);                                                    \
            mode = va_arg(list, mode_t);                                              \
            va_end(list);                                                             \
        }                                                                             \
        if (concerns(path) && fails(#name, flags & O_CREAT)) return -1;               \
        return REAL(int, #name, const char *, int, ...)(path, flags, mode);           \
    }
OPEN(open)
OPEN(open64)

ssize_t write(int fd, const void *data, size_t n) {
    if (fd > 2 && concerns_fd(fd) && fails("write", 1)) return -1;
    return REAL(ssize_t, "write", int, const void *, size_t)(fd, data, n);
}

#define PWRITE(name)                                                                  \
    ssize_t name(int fd, const void *data, size_t n, off_t at) {                      \
        if (concerns_fd(fd) && fails(#name, 1)) return -1;                            \
        return REAL(ssize_t, #name, int, const void *, size_t, off_t)(fd, data, n, at); \
    }
PWRITE(pwrite)
PWRITE(pwrite64)

#define TRUNCATE(name)                                                                \
    int name(int fd, off_t n) {                                                       \
        if (concerns_fd(fd) && fails(#name, 1)) return -1;                            \
        return REAL(int, #name, int, off_t)(fd, n);                                   \
    }
TRUNCATE(ftruncate)
TRUNCATE(ftruncate64)

#define SYNC(name)                                                                    \
    int name(int fd) {                                                                \
        note("sync", fd, 0);                                                          \
        if (concerns_fd(fd) && fails(#name, 0)) return -1;                            \
        return REAL(int, #name, int)(fd);                                             \
    }
SYNC(fsync)
SYNC(fdatasync)

int renameat2(int a, const char *from, int b, const char *to, unsigned flags) {
    note("rename", 0, to);
    if (concerns(to) && fails("renameat2", 0)) return -1;
    return REAL(int, "renameat2", int, const char *, int, const char *, unsigned)(a, from, b, to, flags);
}

int rename(const char *from, const char *to) {
    if (concerns(to) && fails("rename", 0)) return -1;
    return REAL(int, "rename", const char *, const char *)(from, to);
}

int unlink(const char *path) {
    note("unlink", 0, path);
    return REAL(int, "unlink", const char *)(path);
}

int mkdir(const char *path, mode_t mode) {
    if (concerns(path) && fails("mkdir", 1)) return -1;
    return REAL(int, "mkdir", const char *, mode_t)(path, mode);
}
