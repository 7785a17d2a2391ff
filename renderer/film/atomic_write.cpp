#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>

#include "core/errors.h"
#include "film/image_writers.h"

namespace halflight {

namespace {

namespace fs = std::filesystem;

Error write_error(const fs::path& path, const std::string& reason) {
  return Error(ExitCode::failure, fmt::format("{}: cannot write: {}", path.string(), reason));
}

/// An open file; closed on the way out where `close_checked` was not reached.
class OutputFile {
 public:
  OutputFile(const fs::path& path, int flags) : descriptor_(open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~OutputFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  bool is_open() const { return descriptor_ >= 0; }

  bool write_all(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t written = write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      bytes.remove_prefix(static_cast<size_t>(written));
    }
    return true;
  }

  /// On disk for good: some file systems only notice here that they are full. Devices and pipes cannot be
  /// synced.
  bool sync() { return fsync(descriptor_) == 0 || errno == EINVAL || errno == EROFS || errno == ENOTSUP; }

  bool close_checked() {
    const int descriptor = descriptor_;
    descriptor_ = -1;
    return close(descriptor) == 0;
  }

 private:
  int descriptor_;
};

/// A new name beside the target: a rename within one folder is atomic.
fs::path temporary_name(const fs::path& path) {
  static std::atomic<unsigned> count{0};
  return path.parent_path() / fmt::format(".halflight-{}-{}.partial", getpid(), count++);
}

void write_beside_and_rename(const fs::path& path, std::string_view bytes) {
  const fs::path partial = temporary_name(path);
  OutputFile file(partial, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW);
  if (!file.is_open()) throw write_error(path, std::strerror(errno));
  if (file.write_all(bytes) && file.sync() && file.close_checked() &&
      std::rename(partial.c_str(), path.c_str()) == 0)
    return;
  const std::string reason = std::strerror(errno);
  unlink(partial.c_str());
  throw write_error(path, reason);
}

/// Devices and pipes cannot be renamed onto: straight into them.
void write_through(const fs::path& path, std::string_view bytes) {
  OutputFile file(path, O_WRONLY);
  if (!file.is_open() || !file.write_all(bytes) || !file.sync() || !file.close_checked())
    throw write_error(path, std::strerror(errno));
}

}  // namespace

void write_bytes_atomically(const fs::path& path, std::string_view bytes) {
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (fs::is_directory(status)) throw write_error(path, "it is a folder");
  if (fs::exists(status) && !fs::is_regular_file(status)) return write_through(path, bytes);
  // A link stays a link: the file behind it is replaced.
  const fs::path target = fs::exists(status) ? fs::canonical(path, code) : path;
  write_beside_and_rename(code ? path : target, bytes);
}

void write_text_atomically(const fs::path& path, const std::string& text) {
  write_bytes_atomically(path, text);
}

}  // namespace halflight
