#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "core/errors.h"
#include "film/image_writers.h"

namespace halflight {

namespace {

Error write_error(const std::filesystem::path& path, const std::string& reason) {
  return Error(ExitCode::failure, fmt::format("{}: cannot write: {}", path.string(), reason));
}

/// A name beside the target: a rename within one folder is atomic. The ending stays last, libraries look at
/// it.
std::filesystem::path temporary_name(const std::filesystem::path& path) {
  std::filesystem::path name = path;
  name.replace_filename(
      fmt::format(".{}.{}.partial{}", path.stem().string(), getpid(), path.extension().string()));
  return name;
}

/// On disk for good, or an error: a full disk may only show when the file is flushed.
void flush_to_disk(const std::filesystem::path& path) {
  const int file = open(path.c_str(), O_RDONLY);
  const bool done = file >= 0 && (fsync(file) == 0 || errno == EINVAL || errno == EROFS);
  const int code = errno;
  if (file >= 0) close(file);
  if (!done) throw write_error(path, std::strerror(code));
}

}  // namespace

void write_atomically(const std::filesystem::path& path,
                      const std::function<void(const std::filesystem::path&)>& write) {
  std::error_code code;
  const auto status = std::filesystem::status(path, code);
  if (std::filesystem::is_directory(status)) throw write_error(path, "it is a folder");
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    write(path);  // a device or a pipe cannot be renamed onto
    return;
  }
  const std::filesystem::path partial = temporary_name(path);
  try {
    write(partial);
    flush_to_disk(partial);
    std::filesystem::rename(partial, path);
  } catch (const Error&) {
    std::filesystem::remove(partial, code);
    throw;
  } catch (const std::filesystem::filesystem_error& error) {
    std::filesystem::remove(partial, code);
    throw write_error(path, error.code().message());
  } catch (const std::exception& error) {
    std::filesystem::remove(partial, code);
    throw write_error(path, error.what());
  }
}

void write_bytes_atomically(const std::filesystem::path& path, std::string_view bytes) {
  write_atomically(path, [&](const std::filesystem::path& target) {
    errno = 0;
    std::ofstream file(target, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) throw write_error(path, errno != 0 ? std::strerror(errno) : "unknown reason");
  });
}

void write_text_atomically(const std::filesystem::path& path, const std::string& text) {
  write_bytes_atomically(path, text);
}

}  // namespace halflight
