// Recorder of file operations for tests of power cuts: a library for LD_PRELOAD. It appends each operation
// below the folder LOSE_UNSYNCED_FOLDER to the file LOSE_UNSYNCED_JOURNAL. From the journal power_cut.py
// reconstructs the possible disk states after a power cut. LOSE_UNSYNCED_KILL_AT=N ends the process (SIGKILL)
// after operation N.
//
// A journal entry is a Head with its texts and bytes, in the byte order of the machine. Flushes do not reach
// the disk: only the journal counts. Not for programs that use dup(), mmap() or O_APPEND for their output.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

enum Operation { kCreate = 1, kWrite, kTruncate, kFlush, kFlushFolder, kRename, kUnlink };

struct Head {
  uint32_t operation, path_bytes, second_path_bytes, reserved;
  uint64_t inode, offset, data_bytes;
};

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static int journal = -1;
static uint64_t operations, kill_at;

static int is_below_folder(const char* path) {
  const char* folder = getenv("LOSE_UNSYNCED_FOLDER");
  return folder != NULL && strncmp(path, folder, strlen(folder)) == 0;
}

static int is_watched(int fd, char* path) {
  char link[64];
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t length = readlink(link, path, PATH_MAX - 1);
  if (length < 0) return 0;
  path[length] = 0;
  return is_below_folder(path);
}

static uint64_t inode_of(int fd) {
  struct stat status;
  return fstat(fd, &status) == 0 ? status.st_ino : 0;
}

// Requires the mutex. Uses system calls: the intercepted functions would recurse.
static void put(const void* bytes, size_t length) {
  for (const char* at = bytes; length != 0;) {
    const ssize_t written = syscall(SYS_write, journal, at, length);
    if (written <= 0) abort();
    at += written;
    length -= (size_t)written;
  }
}

static void note(enum Operation operation, uint64_t inode, const char* path, const char* second_path,
                 uint64_t offset, const void* data, size_t data_bytes) {
  if (journal < 0) {
    const char* name = getenv("LOSE_UNSYNCED_JOURNAL");
    const char* kill_at_text = getenv("LOSE_UNSYNCED_KILL_AT");
    if (name == NULL) abort();
    journal = (int)syscall(SYS_openat, AT_FDCWD, name, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    if (kill_at_text != NULL) kill_at = strtoull(kill_at_text, NULL, 10);
  }
  const struct Head head = {operation,
                            path != NULL ? (uint32_t)strlen(path) : 0,
                            second_path != NULL ? (uint32_t)strlen(second_path) : 0,
                            0,
                            inode,
                            offset,
                            data_bytes};
  put(&head, sizeof head);
  put(path, head.path_bytes);
  put(second_path, head.second_path_bytes);
  put(data, data_bytes);
  if (++operations == kill_at) kill(getpid(), SIGKILL);
}

static int open_noted(int folder, const char* path, int flags, mode_t mode) {
  const int fd = (int)syscall(SYS_openat, folder, path, flags, mode);
  char full[PATH_MAX];
  if (fd < 0 || (flags & O_CREAT) == 0 || !is_watched(fd, full)) return fd;
  pthread_mutex_lock(&mutex);
  if (flags & (O_EXCL | O_TRUNC)) note(kCreate, inode_of(fd), full, NULL, 0, NULL, 0);
  pthread_mutex_unlock(&mutex);
  return fd;
}

#define MODE_OF(flags, mode)               \
  mode_t mode = 0;                         \
  if ((flags) & (O_CREAT | __O_TMPFILE)) { \
    va_list arguments;                     \
    va_start(arguments, flags);            \
    mode = va_arg(arguments, mode_t);      \
    va_end(arguments);                     \
  }

int open(const char* path, int flags, ...) {
  MODE_OF(flags, mode)
  return open_noted(AT_FDCWD, path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  MODE_OF(flags, mode)
  return open_noted(AT_FDCWD, path, flags, mode);
}

int openat(int folder, const char* path, int flags, ...) {
  MODE_OF(flags, mode)
  return open_noted(folder, path, flags, mode);
}

int openat64(int folder, const char* path, int flags, ...) {
  MODE_OF(flags, mode)
  return open_noted(folder, path, flags, mode);
}

ssize_t pwrite(int fd, const void* data, size_t length, off_t offset) {
  char path[PATH_MAX];
  if (!is_watched(fd, path)) return syscall(SYS_pwrite64, fd, data, length, offset);
  pthread_mutex_lock(&mutex);
  const ssize_t written = syscall(SYS_pwrite64, fd, data, length, offset);
  const int fault = errno;
  if (written > 0) note(kWrite, inode_of(fd), NULL, NULL, (uint64_t)offset, data, (size_t)written);
  pthread_mutex_unlock(&mutex);
  errno = fault;
  return written;
}

ssize_t pwrite64(int fd, const void* data, size_t length, off_t offset) {
  return pwrite(fd, data, length, offset);
}

ssize_t write(int fd, const void* data, size_t length) {
  char path[PATH_MAX];
  if (fd <= STDERR_FILENO || !is_watched(fd, path)) return syscall(SYS_write, fd, data, length);
  pthread_mutex_lock(&mutex);
  const off_t offset = lseek(fd, 0, SEEK_CUR);
  const ssize_t written = syscall(SYS_write, fd, data, length);
  const int fault = errno;
  if (written > 0) note(kWrite, inode_of(fd), NULL, NULL, (uint64_t)offset, data, (size_t)written);
  pthread_mutex_unlock(&mutex);
  errno = fault;
  return written;
}

// Writes the first piece only: short writes are allowed.
ssize_t writev(int fd, const struct iovec* pieces, int count) {
  char path[PATH_MAX];
  if (fd <= STDERR_FILENO || count < 1 || !is_watched(fd, path))
    return syscall(SYS_writev, fd, pieces, count);
  return write(fd, pieces[0].iov_base, pieces[0].iov_len);
}

int ftruncate(int fd, off_t length) {
  char path[PATH_MAX];
  const int watched = is_watched(fd, path);
  pthread_mutex_lock(&mutex);
  const int done = (int)syscall(SYS_ftruncate, fd, length);
  const int fault = errno;
  if (done == 0 && watched) note(kTruncate, inode_of(fd), NULL, NULL, (uint64_t)length, NULL, 0);
  pthread_mutex_unlock(&mutex);
  errno = fault;
  return done;
}

int ftruncate64(int fd, off_t length) {
  return ftruncate(fd, length);
}

static int flush_noted(int fd, long call) {
  char path[PATH_MAX];
  struct stat status;
  if (!is_watched(fd, path) || fstat(fd, &status) != 0) return (int)syscall(call, fd);
  const int is_folder = S_ISDIR(status.st_mode);
  pthread_mutex_lock(&mutex);
  note(is_folder ? kFlushFolder : kFlush, status.st_ino, path, NULL, 0, NULL, 0);
  pthread_mutex_unlock(&mutex);
  return 0;
}

int fsync(int fd) {
  return flush_noted(fd, SYS_fsync);
}

int fdatasync(int fd) {
  return flush_noted(fd, SYS_fdatasync);
}

static int rename_noted(const char* from, const char* to, unsigned flags) {
  pthread_mutex_lock(&mutex);
  const int done = (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, flags);
  const int fault = errno;
  if (done == 0 && is_below_folder(to)) note(kRename, 0, from, to, 0, NULL, 0);
  pthread_mutex_unlock(&mutex);
  errno = fault;
  return done;
}

int rename(const char* from, const char* to) {
  return rename_noted(from, to, 0);
}

// All programs of this project pass AT_FDCWD for both folders.
int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) {
  (void)from_folder;
  (void)to_folder;
  return rename_noted(from, to, flags);
}

int unlink(const char* path) {
  pthread_mutex_lock(&mutex);
  const int done = (int)syscall(SYS_unlinkat, AT_FDCWD, path, 0);
  const int fault = errno;
  if (done == 0 && is_below_folder(path)) note(kUnlink, 0, path, NULL, 0, NULL, 0);
  pthread_mutex_unlock(&mutex);
  errno = fault;
  return done;
}
