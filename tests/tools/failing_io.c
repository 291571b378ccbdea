/* For scripts/try_interruptions.py: loaded by LD_PRELOAD, lets reads and writes of files below a folder fail.
 *
 * FAILING_IO_IN      the folder
 * FAILING_IO         what fails: "read" (EIO), "write" (ENOSPC), "fsync" (EIO) at call number FAILING_IO_AT,
 *                    from 1, of its kind; or "short": every call handles 1000 bytes at most, and every third is
 *                    interrupted first (EINTR)
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const size_t short_bytes = 1000;
static atomic_long calls;

static int is_watched(int fd) {
  const char* folder = getenv("FAILING_IO_IN");
  if (folder == NULL) return 0;
  char link[64], path[PATH_MAX + 1];
  snprintf(link, sizeof(link), "/proc/self/fd/%d", fd);
  const ssize_t length = readlink(link, path, PATH_MAX);
  if (length <= 0) return 0;
  path[length] = '\0';
  return strncmp(path, folder, strlen(folder)) == 0;
}

static int fails_now(const char* kind, int fd) {
  const char* wanted = getenv("FAILING_IO");
  const char* at = getenv("FAILING_IO_AT");
  return wanted != NULL && at != NULL && strcmp(wanted, kind) == 0 && is_watched(fd) &&
         atomic_fetch_add(&calls, 1) + 1 == atol(at);
}

/* The bytes to handle; 0: interrupted. */
static size_t shortened(int fd, size_t count) {
  const char* wanted = getenv("FAILING_IO");
  if (wanted == NULL || strcmp(wanted, "short") != 0 || !is_watched(fd)) return count;
  if (atomic_fetch_add(&calls, 1) % 3 == 2) return 0;
  return count < short_bytes ? count : short_bytes;
}

ssize_t read(int fd, void* to, size_t count) {
  ssize_t (*real)(int, void*, size_t) = (ssize_t(*)(int, void*, size_t))dlsym(RTLD_NEXT, "read");
  if (fails_now("read", fd)) return errno = EIO, -1;
  const size_t some = shortened(fd, count);
  if (some == 0 && count > 0) return errno = EINTR, -1;
  return real(fd, to, some);
}

ssize_t pread(int fd, void* to, size_t count, off_t offset) {
  ssize_t (*real)(int, void*, size_t, off_t) =
      (ssize_t(*)(int, void*, size_t, off_t))dlsym(RTLD_NEXT, "pread");
  if (fails_now("read", fd)) return errno = EIO, -1;
  const size_t some = shortened(fd, count);
  if (some == 0 && count > 0) return errno = EINTR, -1;
  return real(fd, to, some, offset);
}

ssize_t write(int fd, const void* from, size_t count) {
  ssize_t (*real)(int, const void*, size_t) = (ssize_t(*)(int, const void*, size_t))dlsym(RTLD_NEXT, "write");
  if (fails_now("write", fd)) return errno = ENOSPC, -1;
  const size_t some = shortened(fd, count);
  if (some == 0 && count > 0) return errno = EINTR, -1;
  return real(fd, from, some);
}

int fsync(int fd) {
  int (*real)(int) = (int (*)(int))dlsym(RTLD_NEXT, "fsync");
  if (fails_now("fsync", fd)) return errno = EIO, -1;
  return real(fd);
}
